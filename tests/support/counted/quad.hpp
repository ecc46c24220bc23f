// Complex numbers of 34 digits with the sum of the moduli of their terms, beside lanes of two doubles.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

typedef __float128 Q;

inline Q modulus(Q x) { return x < 0 ? -x : x; }

struct Number {
  Q re = 0, im = 0, size = 0;
};
inline Number operator+(const Number& a, const Number& b) { return {a.re + b.re, a.im + b.im, a.size + b.size}; }
inline Number operator-(const Number& a, const Number& b) { return {a.re - b.re, a.im - b.im, a.size + b.size}; }
inline Number operator*(const Number& a, const Number& b) {
  return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re, a.size * b.size};
}

// Numbers as the kernel takes them: number k of lane l stands at k lanes + l.
struct Numbers {
  int lanes;
  std::vector<double> re, im, low_re, low_im;

  Numbers(int count, int lanes)
      : lanes(lanes), re(count * lanes), im(count * lanes), low_re(count * lanes), low_im(count * lanes) {}
  gsp::FineNumbers given() { return {{re.data(), im.data()}, {low_re.data(), low_im.data()}}; }
  gsp::LaneNumbers high() { return {re.data(), im.data()}; }
  Number at(int k, int l) const {
    const int i = k * lanes + l;
    const Q x = Q(re[i]) + low_re[i], y = Q(im[i]) + low_im[i];
    return {x, y, modulus(x) + modulus(y)};
  }
  void put(int k, int l, Q x, Q y) {
    const int i = k * lanes + l;
    re[i] = double(x), low_re[i] = double(x - re[i]), im[i] = double(y), low_im[i] = double(y - im[i]);
  }
  template <class Random>
  void draw(Random& random, int k, int l, double size = 1.0) {
    std::uniform_real_distribution<double> part(-size, size);
    put(k, l, part(random) + 0x1p-53 * Q(part(random)), part(random) + 0x1p-53 * Q(part(random)));
  }
};

// The error of a number as a part of the sizes, and the worst of some.
inline double error(const Number& computed, const Number& exact, Q size) {
  return double(std::max(modulus(computed.re - exact.re), modulus(computed.im - exact.im)) / size);
}
