// SPDX-License-Identifier: MIT

#include "hdf5.h"

#include <functional>
#include <memory>
#include <numeric>

namespace ragdoll::hdf5 {
namespace {

std::mutex& mutex() {
  static std::mutex only;
  return only;
}

Handle text_type(std::size_t size) {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose, "make a text type");
  checked(H5Tset_size(type, size), "size a text type");
  return type;
}

Handle variable_text_type() {
  Handle type = text_type(H5T_VARIABLE);
  checked(H5Tset_cset(type, H5T_CSET_UTF8), "make a text type UTF-8");
  return type;
}

Handle space_of(const Shape& shape) {
  return {shape.empty() ? H5Screate(H5S_SCALAR)
                        : H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr),
          H5Sclose, "make a data space"};
}

Handle open_dataset(hid_t file, const std::string& path) {
  return {H5Dopen2(file, path.c_str(), H5P_DEFAULT), H5Dclose, "find " + path};
}

Handle attribute(hid_t object, const std::string& name, hid_t type, const Shape& shape) {
  return {H5Acreate2(object, name.c_str(), type, space_of(shape), H5P_DEFAULT, H5P_DEFAULT),
          H5Aclose, "make the attribute " + name};
}

Handle making_groups() {
  Handle list(H5Pcreate(H5P_LINK_CREATE), H5Pclose, "make a property list");
  checked(H5Pset_create_intermediate_group(list, 1), "ask for groups");
  return list;
}

// Files appear complete, by renaming: locks would only fail on file systems without them.
Handle disk_access() {
  Handle list(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "make a property list");
  checked(H5Pset_file_locking(list, false, true), "do without file locks");
  return list;
}

// Text of one element, variable or fixed in length; `read` is H5Dread or H5Aread in a wrapper.
std::string one_text(hid_t type, const std::function<herr_t(hid_t, void*)>& read) {
  if (H5Tget_class(type) != H5T_STRING) throw Failure("HDF5 finds no text");
  if (H5Tis_variable_str(type) > 0) {
    char* raw = nullptr;
    checked(read(type, static_cast<void*>(&raw)), "read a text");
    const std::unique_ptr<char, herr_t (*)(void*)> owner(raw, H5free_memory);
    return raw ? std::string(raw) : std::string();
  }
  std::string text(H5Tget_size(type), '\0');
  checked(read(type, text.data()), "read a text");
  return text.substr(0, text.find('\0'));
}

}  // namespace

Session::Session() : lock_(mutex()) {
  H5Eget_auto2(H5E_DEFAULT, &print_, &print_data_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

Session::~Session() {
  H5Eset_auto2(H5E_DEFAULT, print_, print_data_);
}

Handle create_in_memory(std::size_t growth) {
  Handle list(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "make a property list");
  checked(H5Pset_fapl_core(list, growth, false), "work in memory");
  return {H5Fcreate("ragdoll-trajectory-in-memory", H5F_ACC_TRUNC, H5P_DEFAULT, list), H5Fclose,
          "create a file in memory"};
}

Handle create_on_disk(const std::string& path) {
  return {H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, disk_access()), H5Fclose,
          "create the file"};
}

Handle create_compact_on_disk(const std::string& path) {
  const Handle access = disk_access();
  checked(H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110), "choose a format");
  return {H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose, "create the file"};
}

std::vector<std::byte> image_of(hid_t file) {
  checked(H5Fflush(file, H5F_SCOPE_LOCAL), "flush a file in memory");
  const auto size = checked(H5Fget_file_image(file, nullptr, 0), "measure a file in memory");
  std::vector<std::byte> image(static_cast<std::size_t>(size));
  checked(H5Fget_file_image(file, image.data(), image.size()), "copy a file in memory");
  return image;
}

Handle make_group(hid_t file, const std::string& path) {
  return {H5Gcreate2(file, path.c_str(), making_groups(), H5P_DEFAULT, H5P_DEFAULT), H5Gclose,
          "make the group " + path};
}

void make_link(hid_t file, const std::string& existing, const std::string& path) {
  checked(H5Lcreate_hard(file, existing.c_str(), file, path.c_str(), making_groups(), H5P_DEFAULT),
          "link " + path);
}

Handle make_dataset(hid_t file, const std::string& path, hid_t type, const Shape& shape) {
  return {H5Dcreate2(file, path.c_str(), type, space_of(shape), making_groups(), H5P_DEFAULT,
                     H5P_DEFAULT),
          H5Dclose, "make " + path};
}

Handle make_frames(hid_t file, const std::string& path, hsize_t frames, hsize_t atoms) {
  const hsize_t now[] = {frames, atoms, 3}, most[] = {H5S_UNLIMITED, atoms, 3},
                chunk[] = {1, atoms, 3};
  const Handle space(H5Screate_simple(3, now, most), H5Sclose, "make a data space");

  // MDTraj's own default: readable everywhere, and no plugin filter gains more
  const Handle list(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "make a property list");
  checked(H5Pset_chunk(list, 3, chunk), "chunk " + path);
  checked(H5Pset_shuffle(list), "shuffle " + path);
  checked(H5Pset_deflate(list, 1), "compress " + path);
  return {
      H5Dcreate2(file, path.c_str(), file_type<float>(), space, making_groups(), list, H5P_DEFAULT),
      H5Dclose, "make " + path};
}

template <typename T>
void write_array(hid_t file, const std::string& path, const Shape& shape, const T* values) {
  const Handle dataset = make_dataset(file, path, file_type<T>(), shape);
  if (std::accumulate(shape.begin(), shape.end(), hsize_t{1}, std::multiplies<>()) == 0) return;
  checked(H5Dwrite(dataset, memory_type<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values),
          "write " + path);
}

template void write_array(hid_t, const std::string&, const Shape&, const float*);
template void write_array(hid_t, const std::string&, const Shape&, const double*);
template void write_array(hid_t, const std::string&, const Shape&, const std::int32_t*);
template void write_array(hid_t, const std::string&, const Shape&, const std::int64_t*);

void write_text(hid_t file, const std::string& path, const std::string& text) {
  const Handle type = variable_text_type();
  const Handle dataset = make_dataset(file, path, type, {});
  const char* raw = text.c_str();
  checked(H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, static_cast<const void*>(&raw)),
          "write " + path);
}

void write_fixed_text(hid_t file, const std::string& path, const std::string& text) {
  const Handle type = text_type(text.size() + 1);  // room for the terminating null
  const Shape one = {1};
  const Handle list(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "make a property list");
  checked(H5Pset_chunk(list, 1, one.data()), "chunk " + path);
  checked(H5Pset_deflate(list, 1), "compress " + path);
  const Handle dataset(
      H5Dcreate2(file, path.c_str(), type, space_of(one), making_groups(), list, H5P_DEFAULT),
      H5Dclose, "make " + path);
  checked(H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text.c_str()), "write " + path);
}

void set_text(hid_t object, const std::string& name, const std::string& text) {
  const Handle type = variable_text_type();
  const char* raw = text.c_str();
  checked(H5Awrite(attribute(object, name, type, {}), type, static_cast<const void*>(&raw)),
          "write the attribute " + name);
}

void set_texts(hid_t object, const std::string& name, const std::vector<std::string>& texts) {
  const Handle type = variable_text_type();
  std::vector<const char*> raw;
  for (const std::string& text : texts) raw.push_back(text.c_str());
  checked(H5Awrite(attribute(object, name, type, {raw.size()}), type,
                   static_cast<const void*>(raw.data())),
          "write the attribute " + name);
}

template <typename T>
void set_number(hid_t object, const std::string& name, T value) {
  checked(H5Awrite(attribute(object, name, file_type<T>(), {}), memory_type<T>(), &value),
          "write the attribute " + name);
}

template void set_number(hid_t, const std::string&, double);
template void set_number(hid_t, const std::string&, std::int32_t);
template void set_number(hid_t, const std::string&, std::int64_t);

void set_version(hid_t object, int major, int minor) {
  const std::int32_t version[] = {major, minor};
  checked(H5Awrite(attribute(object, "version", file_type<std::int32_t>(), {2}),
                   memory_type<std::int32_t>(), version),
          "write the attribute version");
}

void set_reference(hid_t object, const std::string& name, hid_t file, const std::string& path) {
  hobj_ref_t reference;
  checked(H5Rcreate(&reference, file, path.c_str(), H5R_OBJECT, -1), "refer to " + path);
  checked(H5Awrite(attribute(object, name, H5T_STD_REF_OBJ, {}), H5T_STD_REF_OBJ, &reference),
          "write the attribute " + name);
}

Handle open_to_read(const std::string& path) {
  return {H5Fopen(path.c_str(), H5F_ACC_RDONLY, disk_access()), H5Fclose, "open " + path};
}

bool exists(hid_t file, const std::string& path) {
  // HDF5 wants every group on the way to be there before it answers
  for (std::size_t end = path.find('/', 1);; end = path.find('/', end + 1)) {
    if (H5Lexists(file, path.substr(0, end).c_str(), H5P_DEFAULT) <= 0) return false;
    if (end == std::string::npos) return true;
  }
}

std::vector<std::string> names_in(hid_t file, const std::string& group) {
  std::vector<std::string> names;
  if (!exists(file, group)) return names;
  const Handle handle(H5Oopen(file, group.c_str(), H5P_DEFAULT), H5Oclose, "find " + group);
  const auto take = [](hid_t, const char* name, const H5L_info_t*, void* to) -> herr_t {
    static_cast<std::vector<std::string>*>(to)->emplace_back(name);
    return 0;
  };
  checked(H5Literate(handle, H5_INDEX_NAME, H5_ITER_INC, nullptr, take, &names), "list " + group);
  return names;
}

Shape shape_of(hid_t dataset) {
  const Handle space(H5Dget_space(dataset), H5Sclose, "measure a dataset");
  Shape shape(
      static_cast<std::size_t>(checked(H5Sget_simple_extent_ndims(space), "measure a dataset")));
  checked(H5Sget_simple_extent_dims(space, shape.data(), nullptr), "measure a dataset");
  return shape;
}

template <typename T>
std::vector<T> read_array(hid_t file, const std::string& path) {
  const Handle dataset = open_dataset(file, path);
  const Shape shape = shape_of(dataset);
  std::vector<T> values(
      std::accumulate(shape.begin(), shape.end(), hsize_t{1}, std::multiplies<>()));
  if (!values.empty())
    checked(H5Dread(dataset, memory_type<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()),
            "read " + path);
  return values;
}

template std::vector<float> read_array(hid_t, const std::string&);
template std::vector<double> read_array(hid_t, const std::string&);
template std::vector<std::int32_t> read_array(hid_t, const std::string&);
template std::vector<std::int64_t> read_array(hid_t, const std::string&);

std::string read_text(hid_t file, const std::string& path) {
  const Handle dataset = open_dataset(file, path);
  const Handle type(H5Dget_type(dataset), H5Tclose, "read " + path);
  const Handle space(H5Dget_space(dataset), H5Sclose, "measure " + path);
  if (H5Sget_simple_extent_npoints(space) != 1) throw Failure("HDF5 finds no text at " + path);
  return one_text(type, [&](hid_t memory, void* to) {
    return H5Dread(dataset, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, to);
  });
}

std::string text_attribute(hid_t object, const std::string& name) {
  if (H5Aexists(object, name.c_str()) <= 0) return {};
  const Handle attribute(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose, "read " + name);
  const Handle type(H5Aget_type(attribute), H5Tclose, "read " + name);
  const Handle space(H5Aget_space(attribute), H5Sclose, "measure " + name);
  if (H5Sget_simple_extent_npoints(space) != 1) throw Failure("HDF5 finds no text in " + name);
  return one_text(type, [&](hid_t memory, void* to) { return H5Aread(attribute, memory, to); });
}

}  // namespace ragdoll::hdf5
