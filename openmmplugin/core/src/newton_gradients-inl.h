// NewtonGradients: the steps of `newton` for frameworks whose factor would be too large, such as
// 3-D lattices. Compiled once for each set of instructions, from newton_engine.cpp.

#if defined(RAGDOLL_NEWTON_GRADIENTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef RAGDOLL_NEWTON_GRADIENTS_INL_H_
#undef RAGDOLL_NEWTON_GRADIENTS_INL_H_
#else
#define RAGDOLL_NEWTON_GRADIENTS_INL_H_
#endif

#include <algorithm>  // copy_n, any_of
#include <cmath>      // sqrt
#include <cstddef>
#include <cstdint>
#include <vector>

#include <hwy/highway.h>

#include "newton_plan.h"      // NewtonPlan
#include "newton_rows-inl.h"  // NewtonRows

HWY_BEFORE_NAMESPACE();
namespace ragdoll {
namespace HWY_NAMESPACE {

/// (J^T J + mu) dx = -J^T r by conjugate gradients, of one conformer in doubles: the matrix is
/// never made, its products are those of the rows; what is known of it beforehand are the inverses
/// of its diagonal blocks. Steps need not be exact: each is as good as its caller asks. Of what the
/// rows leave free, such a step decides by what it began with, so where masses weigh they stand for
/// the diagonal blocks.
class NewtonGradients {
 public:
  /// @param masses  by slot: what mu is multiplied by
  NewtonGradients(const NewtonPlan& plan, const std::vector<double>& masses,
                  const NewtonRows<double, true>& rows)
      : plan_(plan),
        masses_(masses),
        rows_(rows),
        weighted_(
            std::any_of(masses.begin(), masses.end(), [](double mass) { return mass != 1; })) {
    const std::size_t count = std::size_t(plan.joints) * kJoint;
    for (Field<double>* field : {&right_, &left_, &step_, &direction_, &product_})
      *field = Field<double>(count);
    blocks_ = Field<double>(std::size_t(plan.moving) * kBlock);
  }

  /// A row that the plan does not know: a contact of the rule.
  struct Contact {
    int p, q;  ///< slots
    double u[3], row;
  };
  std::vector<Contact> contacts;

  /// What a step may leave of the right side, as the diagonal blocks measure it.
  double accuracy = 0.1;

  /// Passes over all rows that the last step took.
  std::int64_t passes() const { return passes_; }

  /// The step from the rows evaluated last; trial = x + step.
  /// @param predicted  what the step takes from the energy, by the linear rows and mu's hold
  /// @param positive   0 if the matrix is not positive
  void solve(const Field<double>& x, double mu, Field<double>& trial, double* predicted,
             double* positive) {
    passes_ = 1;
    enter(mu);
    const std::size_t end = std::size_t(plan_.moving) * kJoint;
    std::copy_n(x + 0, x.size(), trial + 0);
    *predicted = 0;
    *positive = weighted_ ? weigh() : invert();
    if (*positive == 0) return;
    for (std::size_t e = 0; e < end; ++e) {
      left_[e] = right_[e];
      step_[e] = direction_[e] = 0;
    }
    double size = 0, first = 0;
    for (int round = 0; round < most_rounds; ++round) {
      // how much is left, and which way that points
      const double before = size;
      size = precondition(round == 0 ? 0 : 1 / before);
      if (round == 0) first = size;
      if (!(size > accuracy * accuracy * first)) break;
      multiply(mu);
      ++passes_;
      const double curvature = dot(direction_, product_);
      if (!(curvature > 0)) break;
      const double far = size / curvature;
      for (std::size_t e = 0; e < end; ++e) {
        step_[e] += far * direction_[e];
        left_[e] -= far * product_[e];
      }
    }
    double held = 0;
    for (int s = 0; s < plan_.moving; ++s) {
      const double* at = step_ + std::size_t(s) * kJoint;
      held += masses_[std::size_t(s)] * (at[0] * at[0] + at[1] * at[1] + at[2] * at[2]);
    }
    *predicted = 0.5 * (dot(right_, step_) + mu * held);
    for (std::size_t e = 0; e < end; ++e) trial[e] = x[e] + step_[e];
  }

 private:
  static constexpr std::size_t kJoint = NewtonLayout<double, true>::kJoint, kBlock = 3 * kJoint;

  /// Rounds of one step; what they reach by then is a step too.
  static constexpr int most_rounds = 1000;

  // === The right side and the diagonal blocks

  void add_outer(int slot, double stiffness, const double* u, double pull) {
    if (slot >= plan_.moving) return;
    double* block = blocks_ + std::size_t(slot) * kBlock;
    double* right = right_ + std::size_t(slot) * kJoint;
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t r = 0; r < 3; ++r) block[c * kJoint + r] += stiffness * u[c] * u[r];
      right[c] -= pull * u[c];
    }
  }
  void add_hold(int slot, double hold) {
    if (slot >= plan_.moving) return;
    double* block = blocks_ + std::size_t(slot) * kBlock;
    for (std::size_t c = 0; c < 3; ++c) block[c * (kJoint + 1)] += hold;
  }

  void enter(double mu) {
    for (std::size_t e = 0; e < blocks_.size(); ++e) blocks_[e] = 0;
    for (std::size_t e = 0; e < right_.size(); ++e) right_[e] = 0;
    for (std::size_t k = 0; k < plan_.pairs.size(); ++k) {
      const auto& pair = plan_.pairs[k];
      const double* u = rows_.unit + 4 * k;
      const double turn = u[3], row = rows_.row[k];
      add_outer(pair.p, 1 - turn, u, -row);
      add_outer(pair.q, 1 - turn, u, row);
      add_hold(pair.p, turn);
      add_hold(pair.q, turn);
    }
    for (std::size_t v = 0; v < plan_.volumes.size(); ++v) {
      if (!rows_.active[v]) continue;
      for (std::size_t j = 0; j < 4; ++j)
        add_outer(plan_.volumes[v].slot[j], 1, rows_.gradient + (4 * v + j) * kJoint,
                  rows_.excess[v]);
    }
    for (const Contact& contact : contacts) {
      add_outer(contact.p, 1, contact.u, -contact.row);
      add_outer(contact.q, 1, contact.u, contact.row);
    }
    for (int s = 0; s < plan_.moving; ++s) add_hold(s, mu * masses_[std::size_t(s)]);
  }

  /// Each diagonal block by its Cholesky factor. @return false if one is not positive
  bool invert() {
    for (std::size_t s = 0; s < std::size_t(plan_.moving); ++s) {
      double* a = blocks_ + s * kBlock;
      const double l00 = std::sqrt(a[0]), l10 = a[1] / l00, l20 = a[2] / l00;
      const double l11 = std::sqrt(a[kJoint + 1] - l10 * l10);
      const double l21 = (a[kJoint + 2] - l20 * l10) / l11;
      const double l22 = std::sqrt(a[2 * kJoint + 2] - l20 * l20 - l21 * l21);
      // negative or no number: so is what it is made of
      if (!(l00 > 0) || !(l11 > 0) || !(l22 > 0)) return false;
      const double i00 = 1 / l00, i11 = 1 / l11, i22 = 1 / l22;
      const double i10 = -l10 * i00 * i11, i21 = -l21 * i11 * i22;
      const double i20 = -(l20 * i00 + l21 * i10) * i22;
      a[0] = i00 * i00 + i10 * i10 + i20 * i20;
      a[1] = a[kJoint] = i10 * i11 + i20 * i21;
      a[2] = a[2 * kJoint] = i20 * i22;
      a[kJoint + 1] = i11 * i11 + i21 * i21;
      a[kJoint + 2] = a[2 * kJoint + 1] = i21 * i22;
      a[2 * kJoint + 2] = i22 * i22;
    }
    return true;
  }

  bool weigh() {
    for (std::size_t s = 0; s < std::size_t(plan_.moving); ++s)
      for (std::size_t e = 0; e < kBlock; ++e)
        blocks_[s * kBlock + e] = e % (kJoint + 1) == 0 ? 1 / masses_[s] : 0;
    return true;
  }

  // === Rounds

  double dot(const Field<double>& one, const Field<double>& two) const {
    double sum[kJoint] = {};
    const std::size_t end = std::size_t(plan_.moving) * kJoint;
    for (std::size_t e = 0; e < end; e += kJoint)
      for (std::size_t c = 0; c < kJoint; ++c) sum[c] += one[e + c] * two[e + c];
    return (sum[0] + sum[1]) + sum[2];
  }

  /// The next direction: what is left, by the inverses, and a part of the one before.
  /// @param over  1 over what was left before, 0 for none
  /// @return how much is left
  double precondition(double over) {
    double sum[kJoint] = {};
    const std::size_t moving = std::size_t(plan_.moving);
    for (std::size_t s = 0; s < moving; ++s) {
      const double* a = blocks_ + s * kBlock;
      const double* r = left_ + s * kJoint;
      double* z = product_ + s * kJoint;  // free until the next product
      for (std::size_t c = 0; c < kJoint; ++c) {
        z[c] = a[c] * r[0] + a[kJoint + c] * r[1] + a[2 * kJoint + c] * r[2];
        sum[c] += z[c] * r[c];
      }
    }
    const double size = (sum[0] + sum[1]) + sum[2], keep = size * over;
    for (std::size_t e = 0; e < moving * kJoint; ++e)
      direction_[e] = product_[e] + keep * direction_[e];
    return size;
  }

  /// product = (J^T J + mu) direction. Fixed joints have no direction; what is pulled at them is
  /// not read.
  void multiply(double mu) {
    for (std::size_t s = 0; s < std::size_t(plan_.moving); ++s) {
      const double hold = mu * masses_[s];
      for (std::size_t c = 0; c < kJoint; ++c)
        product_[s * kJoint + c] = hold * direction_[s * kJoint + c];
    }
    const auto* pair = plan_.pairs.data();
    for (std::size_t k = 0; k < plan_.pairs.size(); ++k) {
      const double* u = rows_.unit + 4 * k;
      const double* from = direction_ + std::size_t(pair[k].p) * kJoint;
      const double* to = direction_ + std::size_t(pair[k].q) * kJoint;
      double* at_p = product_ + std::size_t(pair[k].p) * kJoint;
      double* at_q = product_ + std::size_t(pair[k].q) * kJoint;
      const double d[3] = {to[0] - from[0], to[1] - from[1], to[2] - from[2]};
      const double turn = u[3];
      const double along = (1 - turn) * (u[0] * d[0] + u[1] * d[1] + u[2] * d[2]);
      for (std::size_t c = 0; c < 3; ++c) {
        const double force = along * u[c] + turn * d[c];
        at_p[c] -= force;
        at_q[c] += force;
      }
    }
    for (std::size_t v = 0; v < plan_.volumes.size(); ++v) {
      if (!rows_.active[v]) continue;
      const auto& slot = plan_.volumes[v].slot;
      const double* g = rows_.gradient + 4 * v * kJoint;
      double along = 0;
      for (std::size_t j = 0; j < 4; ++j) {
        const double* d = direction_ + std::size_t(slot[j]) * kJoint;
        for (std::size_t c = 0; c < 3; ++c) along += g[j * kJoint + c] * d[c];
      }
      for (std::size_t j = 0; j < 4; ++j) {
        double* at = product_ + std::size_t(slot[j]) * kJoint;
        for (std::size_t c = 0; c < 3; ++c) at[c] += along * g[j * kJoint + c];
      }
    }
    for (const Contact& contact : contacts) {
      double along = 0;
      for (std::size_t c = 0; c < 3; ++c)
        along += contact.u[c] * (direction_[std::size_t(contact.q) * kJoint + c] -
                                 direction_[std::size_t(contact.p) * kJoint + c]);
      for (std::size_t c = 0; c < 3; ++c) {
        product_[std::size_t(contact.p) * kJoint + c] -= along * contact.u[c];
        product_[std::size_t(contact.q) * kJoint + c] += along * contact.u[c];
      }
    }
  }

  const NewtonPlan& plan_;
  const std::vector<double>& masses_;
  const NewtonRows<double, true>& rows_;
  bool weighted_;
  Field<double> right_, left_;      ///< the right side; what the step leaves of it
  Field<double> step_, direction_;  ///< 0 for fixed joints
  Field<double> product_;
  Field<double> blocks_;  ///< diagonal blocks, then their inverses
  std::int64_t passes_ = 0;
};

}  // namespace HWY_NAMESPACE
}  // namespace ragdoll
HWY_AFTER_NAMESPACE();

#endif
