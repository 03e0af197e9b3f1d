// The little of HDF5's C interface that trajectories need, with handles that close themselves.
//
// SPDX-License-Identifier: MIT

#pragma once
#include <hdf5.h>

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace ragdoll::hdf5 {

/// HDF5 refused; callers turn it into a sentence that names the file.
class Failure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Use of HDF5 by one thread at a time, with its own error printing switched off meanwhile.
/// Every function below expects the caller to hold one.
class Session {
 public:
  Session();
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

 private:
  std::unique_lock<std::mutex> lock_;
  H5E_auto2_t print_ = nullptr;
  void* print_data_ = nullptr;
};

/// Throws Failure("HDF5 cannot <what>") for the negative results by which HDF5 reports errors.
template <typename Result>
Result checked(Result result, const std::string& what) {
  if (result < 0) throw Failure("HDF5 cannot " + what);
  return result;
}

/// An HDF5 identifier that is closed with its scope.
class Handle {
 public:
  Handle() = default;
  Handle(hid_t id, herr_t (*closer)(hid_t), const std::string& what)
      : id_(checked(id, what)), close_(closer) {}
  Handle(Handle&& other) noexcept
      : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }

  operator hid_t() const { return id_; }

  /// Closes now; unlike the destructor it reports a failure.
  void close(const std::string& what) {
    if (id_ >= 0) checked(close_(std::exchange(id_, H5I_INVALID_HID)), what);
  }

 private:
  hid_t id_ = H5I_INVALID_HID;
  herr_t (*close_)(hid_t) = nullptr;
};

/// Type of T in memory, and in files (little-endian).
template <typename T>
hid_t memory_type() {
  if constexpr (std::is_same_v<T, float>) return H5T_NATIVE_FLOAT;
  if constexpr (std::is_same_v<T, double>) return H5T_NATIVE_DOUBLE;
  if constexpr (std::is_same_v<T, std::int32_t>) return H5T_NATIVE_INT32;
  if constexpr (std::is_same_v<T, std::int64_t>) return H5T_NATIVE_INT64;
}
template <typename T>
hid_t file_type() {
  if constexpr (std::is_same_v<T, float>) return H5T_IEEE_F32LE;
  if constexpr (std::is_same_v<T, double>) return H5T_IEEE_F64LE;
  if constexpr (std::is_same_v<T, std::int32_t>) return H5T_STD_I32LE;
  if constexpr (std::is_same_v<T, std::int64_t>) return H5T_STD_I64LE;
}

using Shape = std::vector<hsize_t>;

// making files
Handle create_in_memory(std::size_t growth);
Handle create_on_disk(const std::string& path);
Handle create_compact_on_disk(const std::string& path);  ///< for many small objects; HDF5 1.10
std::vector<std::byte> image_of(hid_t file);

// making objects; parent groups appear as needed
Handle make_group(hid_t file, const std::string& path);
void make_link(hid_t file, const std::string& existing, const std::string& path);
Handle make_dataset(hid_t file, const std::string& path, hid_t type, const Shape& shape);
Handle make_frames(hid_t file, const std::string& path, hsize_t frames, hsize_t atoms);
template <typename T>
void write_array(hid_t file, const std::string& path, const Shape& shape, const T* values);
void write_text(hid_t file, const std::string& path, const std::string& text);
/// A fixed-length text in an array of one, compressed, as MDTraj expects its topology.
void write_fixed_text(hid_t file, const std::string& path, const std::string& text);

// attributes of an open object; texts are variable-length UTF-8, which MDAnalysis insists on
void set_text(hid_t object, const std::string& name, const std::string& text);
void set_texts(hid_t object, const std::string& name, const std::vector<std::string>& texts);
template <typename T>
void set_number(hid_t object, const std::string& name, T value);
void set_version(hid_t object, int major, int minor);
void set_reference(hid_t object, const std::string& name, hid_t file, const std::string& path);

// reading
Handle open_to_read(const std::string& path);
bool exists(hid_t file, const std::string& path);
std::vector<std::string> names_in(hid_t file, const std::string& group);  ///< sorted; or none
Shape shape_of(hid_t dataset);
template <typename T>
std::vector<T> read_array(hid_t file, const std::string& path);
std::string read_text(hid_t file, const std::string& path);
std::string text_attribute(hid_t object, const std::string& name);  ///< empty if it is missing

}  // namespace ragdoll::hdf5
