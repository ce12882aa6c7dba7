#include "vision/stereo/fusion_kernel.hpp"

#include <limits>

// Highway compiles this file once for each SIMD target; the table of targets is at the bottom.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vision/stereo/fusion_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kawara::vision::fusion {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, kBlock>;

/// A group wins over one before it by more than rounding only.
constexpr float kTie = 1.00001F;
/// No deviation counts for less, in parts of the range.
constexpr float kLeastRelativeSd = 1e-5F;

/// What the estimates of a vector's pixels say, in inverse range [1/m]; unknown: NaN, weight 0.
struct Estimates {
  HWY_ALIGN float inverse[kMostSources * kBlock];
  HWY_ALIGN float variance[kMostSources * kBlock];
  HWY_ALIGN float weight[kMostSources * kBlock];
};

// How many of the estimates are known.
HWY_INLINE hn::Vec<F> LoadEstimates(const Source* sources, std::size_t count, std::size_t at,
                                    Estimates& estimates) {
  const F f;
  const auto one = hn::Set(f, 1.0F);
  auto known_count = hn::Zero(f);
  for (std::size_t k = 0; k < count; ++k) {
    const auto range = hn::LoadU(f, sources[k].range_m + at);
    const auto sd = hn::LoadU(f, sources[k].sd_m + at);
    const auto inverse = hn::Div(one, range);
    const auto relative = hn::Max(hn::Mul(sd, inverse), hn::Set(f, kLeastRelativeSd));
    const auto sd_inverse = hn::Mul(relative, inverse);
    const auto variance = hn::Mul(sd_inverse, sd_inverse);
    const auto known = hn::Eq(range, range);
    hn::Store(inverse, f, estimates.inverse + k * kBlock);
    hn::Store(variance, f, estimates.variance + k * kBlock);
    hn::Store(hn::IfThenElseZero(known, hn::Div(one, variance)), f, estimates.weight + k * kBlock);
    known_count = hn::Add(known_count, hn::IfThenElseZero(known, one));
  }
  return known_count;
}

void Fuse(const Source* sources, std::size_t count, const Rules& rules, std::size_t pixels,
          float* range_m, float* sd_m) {
  const F f;
  const auto unknown = hn::Set(f, std::numeric_limits<float>::quiet_NaN());
  const auto zero = hn::Zero(f), one = hn::Set(f, 1.0F);
  const auto gate = hn::Set(f, rules.agreement_square);
  const auto own_part = hn::Set(f, 1.0F - rules.directed - rules.alike);
  Estimates estimates;
  for (std::size_t at = 0; at < pixels; at += hn::Lanes(f)) {
    const auto known_count = LoadEstimates(sources, count, at, estimates);
    if (hn::AllTrue(f, hn::Eq(known_count, zero))) {
      hn::StoreU(unknown, f, range_m + at);
      hn::StoreU(unknown, f, sd_m + at);
      continue;
    }
    // False for NaN, so what is not known agrees with nothing.
    const auto agrees = [&](std::size_t k, auto inverse, auto variance) {
      const auto apart = hn::Sub(hn::Load(f, estimates.inverse + k * kBlock), inverse);
      const auto both = hn::Add(hn::Load(f, estimates.variance + k * kBlock), variance);
      return hn::Le(hn::Mul(apart, apart), hn::Mul(gate, both));
    };
    auto best = zero, centre = unknown, centre_variance = unknown;
    for (std::size_t k = 0; k < count; ++k) {
      const auto inverse = hn::Load(f, estimates.inverse + k * kBlock);
      const auto variance = hn::Load(f, estimates.variance + k * kBlock);
      auto sum = zero;
      for (std::size_t j = 0; j < count; ++j) {
        sum = hn::Add(sum, hn::IfThenElseZero(agrees(j, inverse, variance),
                                              hn::Load(f, estimates.weight + j * kBlock)));
      }
      const auto better = hn::Gt(sum, hn::Mul(best, hn::Set(f, kTie)));
      best = hn::IfThenElse(better, sum, best);
      centre = hn::IfThenElse(better, inverse, centre);
      centre_variance = hn::IfThenElse(better, variance, centre_variance);
    }
    // About the centre, which is near: sums of differences keep their digits.
    auto members = zero, offset = zero, square = zero, alike = zero;
    auto along_0 = zero, along_1 = zero, along_2 = zero;
    for (std::size_t k = 0; k < count; ++k) {
      const auto member = agrees(k, centre, centre_variance);
      const auto weight = hn::IfThenElseZero(member, hn::Load(f, estimates.weight + k * kBlock));
      const auto apart =
          hn::IfThenElseZero(member, hn::Sub(hn::Load(f, estimates.inverse + k * kBlock), centre));
      const auto pull = hn::Sqrt(weight);  // weight * deviation
      members = hn::Add(members, hn::IfThenElseZero(member, one));
      offset = hn::MulAdd(weight, apart, offset);
      square = hn::MulAdd(hn::Mul(weight, apart), apart, square);
      alike = hn::Add(alike, pull);
      along_0 = hn::MulAdd(pull, hn::Set(f, sources[k].direction[0]), along_0);
      along_1 = hn::MulAdd(pull, hn::Set(f, sources[k].direction[1]), along_1);
      along_2 = hn::MulAdd(pull, hn::Set(f, sources[k].direction[2]), along_2);
    }
    const auto per_weight = hn::Div(one, best);
    const auto mean_offset = hn::Mul(offset, per_weight);
    const auto range = hn::Div(one, hn::Add(centre, mean_offset));
    const auto directed =
        hn::MulAdd(along_0, along_0, hn::MulAdd(along_1, along_1, hn::Mul(along_2, along_2)));
    const auto shared = hn::MulAdd(hn::Set(f, rules.directed), directed,
                                   hn::Mul(hn::Set(f, rules.alike), hn::Mul(alike, alike)));
    auto variance = hn::Mul(hn::MulAdd(shared, per_weight, own_part), per_weight);
    const auto lone = hn::Lt(members, hn::Set(f, 1.5F));
    const auto scatter =
        hn::Div(hn::Sub(square, hn::Mul(offset, mean_offset)), hn::Max(hn::Sub(members, one), one));
    variance = hn::Mul(variance,
                       hn::IfThenElse(lone, hn::Set(f, rules.alone_square), hn::Max(scatter, one)));
    const auto relative = hn::Mul(hn::Sqrt(variance), range);
    const auto majority = hn::Gt(hn::Add(members, members), known_count);
    // False for NaN.
    const auto good = hn::And(majority, hn::Le(relative, hn::Set(f, rules.largest_relative_sd)));
    hn::StoreU(hn::IfThenElse(good, range, unknown), f, range_m + at);
    hn::StoreU(hn::IfThenElse(good, hn::Mul(relative, range), unknown), f, sd_m + at);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace kawara::vision::fusion
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kawara::vision::fusion {

HWY_EXPORT(Fuse);

void Fuse(const Source* sources, std::size_t count, const Rules& rules, std::size_t pixels,
          float* range_m, float* sd_m) {
  HWY_DYNAMIC_DISPATCH(Fuse)(sources, count, rules, pixels, range_m, sd_m);
}

}  // namespace kawara::vision::fusion
#endif  // HWY_ONCE
