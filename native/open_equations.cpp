#include "open_equations.hpp"

#include <cmath>

#include "pair.hpp"

namespace gsp {
namespace {

// Positions of the forms (`study`).
constexpr int kNorm = 0, kRotation = 1, kTranslation = 10, kBody = 13, kRho = 16, kMoment = 17,
              kStudy = 26;

Pair pair(const Doubled& a) { return {a.high, a.low}; }
Doubled sized(const Pair& x, double size) { return {x.hi, x.lo, size}; }
Doubled operator+(const Doubled& a, const Doubled& b) {
  return sized(sum(pair(a), pair(b)), a.size + b.size);
}
Doubled operator*(const Doubled& a, const Doubled& b) {
  return sized(product(pair(a), pair(b)), a.size * b.size);
}
Doubled operator-(const Doubled& a) { return {-a.high, -a.low, a.size}; }
Doubled operator-(const Doubled& a, const Doubled& b) { return a + -b; }
// By a power of two.
Doubled operator*(double c, const Doubled& a) { return {c * a.high, c * a.low, std::fabs(c) * a.size}; }

// Of a positive number that is as large as its size.
Doubled root(const Doubled& x) {
  const double r = std::sqrt(x.high);
  const Doubled square = Doubled{r, 0.0, r} * Doubled{r, 0.0, r};
  return sized(renormalized(r, (x - square).high / (2.0 * r)), std::sqrt(x.size));
}

Doubled dot(const Doubled* a, const Doubled* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

struct Vector {
  Doubled entry[3];
};
Vector cross(const Doubled* a, const Doubled* b) {
  Vector c;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    c.entry[i] = a[j] * b[k] - a[k] * b[j];
  }
  return c;
}

struct Form {
  Doubled of[kStudyForms];

  // Adds c left . R right.
  void turn(double c, const Doubled* left, const Doubled* right) {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        Doubled& entry = of[kRotation + 3 * i + j];
        entry = entry + c * (left[i] * right[j]);
      }
  }
  Form scaled(const Doubled& factor) const {
    Form form;
    for (int i = 0; i < kStudyForms; ++i) form.of[i] = factor * of[i];
    return form;
  }
};

// |R a + T - b|^2.
Form square_distance(const Primitives& p) {
  Form form;
  form.turn(-2.0, p.b, p.a);
  form.of[kNorm] = dot(p.a, p.a) + dot(p.b, p.b);
  form.of[kRho] = {1.0, 0.0, 1.0};
  for (int k = 0; k < 3; ++k) {
    form.of[kBody + k] = 2.0 * p.a[k];
    form.of[kTranslation + k] = -2.0 * p.b[k];
  }
  return form;
}

// v . (R a + T - b).
Form base_height(const Primitives& p) {
  Form form;
  form.turn(1.0, p.v, p.a);
  form.of[kNorm] = -dot(p.v, p.b);
  for (int k = 0; k < 3; ++k) form.of[kTranslation + k] = p.v[k];
  return form;
}

// R u . (R a + T - b).
Form platform_height(const Primitives& p) {
  Form form;
  form.turn(-1.0, p.b, p.u);
  form.of[kNorm] = dot(p.u, p.a);
  for (int k = 0; k < 3; ++k) form.of[kBody + k] = p.u[k];
  return form;
}

// (R a + T - b) . (R u x v).
Form mutual_moment(const Primitives& p) {
  Form form;
  form.turn(1.0, p.v, cross(p.a, p.u).entry);
  form.turn(-1.0, cross(p.v, p.b).entry, p.u);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) form.of[kMoment + 3 * i + j] = p.v[i] * p.u[j];
  return form;
}

class Writer {
 public:
  Writer(const double* tables, double tiny, OpenEquations& out) : tiny_(tiny), out_(out) {
    out_.quadrics = 0;
    Term* end = terms_;
    for (int i = 0; i < kEntries; ++i) {
      for (int k = 0; k < kStudyForms; ++k)
        if (tables[k * kEntries + i] != 0.0) *end++ = {k, tables[k * kEntries + i]};
      end_[i] = static_cast<int>(end - terms_);
    }
  }

  // A quadric; of the main one of an equation (-1: none) N is bounded apart.
  int add(const Form& form, int equation = -1) {
    double bound[kStudyForms];
    for (int k = 0; k < kStudyForms; ++k) bound[k] = form.of[k].size + tiny_;
    if (equation >= 0) {
      out_.norm_bound[equation] = bound[kNorm];
      bound[kNorm] = 0.0;
    }
    const int start = out_.quadrics * kEntries;
    for (int i = 0, t = 0; i < kEntries; ++i) {
      Doubled entry;
      double moduli = 0.0;
      for (; t < end_[i]; ++t) {
        const auto [k, c] = terms_[t];
        entry = entry + c * form.of[k];
        moduli += std::fabs(c) * bound[k];
      }
      out_.hessian[start + i] = entry.high;
      out_.low[start + i] = entry.low;
      out_.moduli[start + i] = moduli;
    }
    return out_.quadrics++;
  }

  void put(int equation, const Form& main, const Doubled& weight) {
    out_.weight[equation] = weight.high;
    out_.weight_low[equation] = weight.low;
    out_.weight_bound[equation] = weight.size + tiny_;
    out_.table[3 * equation] = add(main, equation);
    out_.table[3 * equation + 1] = out_.table[3 * equation + 2] = out_.turned[equation] = -1;
  }

  void put_squares(int equation, const Form& first) { out_.table[3 * equation + 1] = add(first); }
  void put_squares(int equation, const Form& first, const Form& turned) {
    put_squares(equation, first);
    out_.turned[equation] = out_.table[3 * equation + 2] = add(turned);
  }

 private:
  static constexpr int kEntries = kVariables * kVariables;
  // Part of an entry of a Hessian matrix: so many times a form.
  struct Term {
    int form;
    double factor;
  };

  // Few are not zero; those of each entry, one after the other, and where they end.
  Term terms_[kStudyForms * kEntries];
  int end_[kEntries];
  double tiny_;
  OpenEquations& out_;
};

void write(const Primitives& p, int equation, Writer& writer) {
  const Doubled one{1.0, 0.0, 1.0};
  switch (p.relation) {
    case Relation::kPoints: return writer.put(equation, square_distance(p), -one);
    case Relation::kBaseHeight: return writer.put(equation, base_height(p), -root(dot(p.v, p.v)));
    case Relation::kPlatformHeight:
      return writer.put(equation, platform_height(p).scaled(-one), -root(dot(p.u, p.u)));
    case Relation::kBaseLine:
    case Relation::kPlatformLine: {
      const bool base = p.relation == Relation::kBaseLine;
      const Doubled axis = base ? dot(p.v, p.v) : dot(p.u, p.u);
      writer.put(equation, square_distance(p).scaled(axis), -axis);
      return writer.put_squares(equation, base ? base_height(p) : platform_height(p));
    }
    case Relation::kLines: {
      Form cosine;
      cosine.turn(1.0, p.v, p.u);
      writer.put(equation, Form{}, dot(p.u, p.u) * dot(p.v, p.v));
      return writer.put_squares(equation, mutual_moment(p), cosine);
    }
    // Lines at distance zero: their moment is zero, whose square has no simple solutions.
    case Relation::kMeetingLines: return writer.put(equation, mutual_moment(p), Doubled{});
    case Relation::kAngle: {
      Form cosine;
      cosine.turn(1.0, p.v, p.u);
      return writer.put(equation, cosine, -(root(dot(p.u, p.u)) * root(dot(p.v, p.v))));
    }
  }
}

}  // namespace

void open_equations(const Primitives* constraints, const double* tables, double tiny,
                    OpenEquations& out) {
  Writer writer(tables, tiny, out);
  Form norm, study;
  norm.of[kNorm] = study.of[kStudy] = {1.0, 0.0, 1.0};
  writer.add(norm);
  writer.add(study);
  for (int i = 0; i < kEquations; ++i) write(constraints[i], i, writer);
}

}  // namespace gsp
