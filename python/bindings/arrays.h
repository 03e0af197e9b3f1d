// Arrays: numpy arrays in and out of core's plain vectors.

#pragma once
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>  // copy
#include <array>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <vector>

#include "ragdoll/vec3.h"  // Vec3

namespace ragdoll::bindings {

namespace nb = nanobind;

/// Read-only input of any layout that numpy can make contiguous.
template <class T, class Shape>
using In = nb::ndarray<const T, Shape, nb::c_contig, nb::device::cpu>;
using InPoints = In<double, nb::shape<-1, 3>>;
using InPairs = In<std::int32_t, nb::shape<-1, 2>>;
template <class T>
using InVector = In<T, nb::shape<-1>>;

/// A new numpy array that owns a copy of the values.
template <class T>
nb::object out(const std::vector<T>& values, std::initializer_list<std::size_t> shape) {
  T* data = new T[std::max<std::size_t>(values.size(), 1)];
  std::copy(values.begin(), values.end(), data);
  nb::capsule owner(data, [](void* p) noexcept { delete[] static_cast<T*>(p); });
  return nb::cast(nb::ndarray<nb::numpy, T>(data, shape, owner));
}

template <class T>
nb::object out(const std::vector<T>& values) {
  return out(values, {values.size()});
}

inline std::vector<Vec3> points_of(const InPoints& array) {
  std::vector<Vec3> points(array.shape(0));
  const double* x = array.data();
  for (std::size_t j = 0; j < points.size(); ++j)
    points[j] = Vec3(x[3 * j], x[3 * j + 1], x[3 * j + 2]);
  return points;
}

inline nb::object out_points(const std::vector<Vec3>& points) {
  std::vector<double> flat(3 * points.size());
  for (std::size_t j = 0; j < points.size(); ++j)
    for (std::size_t k = 0; k < 3; ++k) flat[3 * j + k] = points[j][Eigen::Index(k)];
  return out(flat, {points.size(), 3});
}

/// The joints of bars, tethers or contacts. (n, 2)
template <class Pair>
nb::object joints_of(const std::vector<Pair>& pairs) {
  std::vector<std::int32_t> joints;
  joints.reserve(2 * pairs.size());
  for (const Pair& pair : pairs) {
    joints.push_back(pair.p);
    joints.push_back(pair.q);
  }
  return out(joints, {pairs.size(), 2});
}

/// Their lengths. (n)
template <class Pair>
nb::object lengths_of(const std::vector<Pair>& pairs) {
  std::vector<double> lengths;
  lengths.reserve(pairs.size());
  for (const Pair& pair : pairs) lengths.push_back(pair.length);
  return out(lengths);
}

template <class T>
void check_size(const T& array, std::size_t size, const char* name) {
  if (array.shape(0) != size)
    throw std::invalid_argument(std::string(name) + " has " + std::to_string(array.shape(0)) +
                                " entries instead of " + std::to_string(size));
}

}  // namespace ragdoll::bindings
