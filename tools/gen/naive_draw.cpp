// Draws of the oracle: the table of compiler/docs/semantics.md, *Draws*, taken literally.
#include <cmath>

#include "tools/gen/naive_value.hpp"

namespace bip::gen {
namespace {

constexpr std::uint64_t kGamma = 0x9e3779b97f4a7c15;

std::uint64_t mix(std::uint64_t z) {
  z ^= z >> 30;
  z *= 0xbf58476d1ce4e5b9;
  z ^= z >> 27;
  z *= 0x94d049bb133111eb;
  return z ^ z >> 31;
}

}  // namespace

std::uint64_t first_of_generator(std::uint64_t seed, std::uint64_t atom) {
  const std::uint64_t s = mix(mix(seed + kGamma) + (atom + 1) * kGamma);
  return s == 0 ? 1 : s;
}

Value draw_value(const Expr& expr, const Lookup& lookup, Place& at) {
  std::vector<Value> args;
  bool has_floats = false;
  for (const Expr& arg : expr.args) {
    args.push_back(evaluate(arg, lookup, at));
    has_floats |= args.back().type == Ty::Float;
    if (at.fault) return {};
  }
  const auto next = [&at] { return mix(*at.generator += kGamma); };
  const auto share = [&next] { return static_cast<double>(next() >> 11) / 9007199254740992.0; };
  const auto positive_share = [&next] { return static_cast<double>((next() >> 11) + 1) / 9007199254740992.0; };
  if (expr.text == "flip") return of_bool(share() < args[0].f);
  if (expr.text == "exponential") return of_float(-args[0].f * std::log(positive_share()));
  if (expr.text == "normal") {
    const double radius = std::sqrt(-2 * std::log(positive_share()));
    const double z = radius * std::cos(2 * 3.14159265358979323846 * share());
    return of_float(args[0].f + args[1].f * z);
  }
  if (expr.text == "uniform" && has_floats) {
    const double low = args[0].f, high = args[1].f, u = share();
    const double value = low * (1 - u) + high * u;
    return of_float(value < high ? value : std::nextafter(high, low));
  }
  if (expr.text == "uniform") {
    at.fault = args[0].i > args[1].i;
    if (at.fault) return {};
    // The width is at most 2^32, so that a number is drawn again once in 2^32 draws: by the definition.
    const std::uint64_t n = static_cast<std::uint64_t>(std::int64_t{args[1].i} - args[0].i) + 1;
    __extension__ using Wide128 = unsigned __int128;
    Wide128 product = 0;
    do {
      product = static_cast<Wide128>(next()) * n;
    } while (static_cast<std::uint64_t>(product) < (0 - n) % n);
    return of_int(args[0].i + static_cast<std::int64_t>(static_cast<std::uint64_t>(product >> 64)));
  }
  double sum = 0;
  for (std::size_t k = 1; k < args.size(); k += 2) sum += args[k].f;
  at.fault = sum == 0;
  if (at.fault) return {};
  double left = share() * sum;
  std::size_t last = 0;
  for (std::size_t k = 0; k < args.size(); k += 2) {
    if (args[k + 1].f == 0) continue;
    last = k;
    if (left < args[k + 1].f) break;
    left -= args[k + 1].f;
  }
  return of_int(args[last].i);
}

}  // namespace bip::gen
