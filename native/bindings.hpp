// What the Python bindings share: arrays that own their data, checks of arguments, and the parts of the
// module that have one build (modules.hpp has the others).
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>
#include <cstddef>
#include <initializer_list>
#include <memory>
#include <stdexcept>

namespace gsp {

namespace nb = nanobind;

template <class T, int dimensions>
using Array = nb::ndarray<const T, nb::ndim<dimensions>, nb::c_contig, nb::device::cpu>;

template <class T>
nb::ndarray<nb::numpy, T> owned(std::unique_ptr<T[]> data,
                                std::initializer_list<std::size_t> shape) {
  T* raw = data.release();
  nb::capsule owner(raw, [](void* p) noexcept { delete[] static_cast<T*>(p); });
  return nb::ndarray<nb::numpy, T>(raw, shape, owner);
}

template <class T>
nb::ndarray<nb::numpy, T> copied(const T* from, std::size_t count) {
  auto data = std::make_unique<T[]>(count);
  std::copy(from, from + count, data.get());
  return owned(std::move(data), {count});
}

inline void require(bool condition, const char* message) {
  if (!condition) throw std::invalid_argument(message);
}

void bind_bodies(nb::module_& m);
void bind_controller(nb::module_& m);
void bind_gaps(nb::module_& m);
void bind_ordering(nb::module_& m);
void bind_reach(nb::module_& m);

}  // namespace gsp
