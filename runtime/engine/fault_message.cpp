// See fault_message.hpp.
#include "runtime/engine/fault_message.hpp"

#include <algorithm>

namespace bip::rt {

namespace {

constexpr std::size_t kNumbers = 12, kTexts = 4;

}  // namespace

Control fault_message(u64 step, u32 order, const Fault& fault) {
  return {Control::Kind::Fault,
          {step, order, static_cast<u64>(fault.code), fault.atom, fault.connector, fault.port, fault.loc.file,
           fault.loc.line, fault.loc.column, fault.other.file, fault.other.line, fault.other.column},
          {fault.what, fault.rule, fault.places, fault.data}};
}

std::optional<FaultOfStep> read_fault_message(const Control& control, const Image& image) {
  if (control.numbers.size() != kNumbers || control.texts.size() != kTexts) return std::nullopt;
  const std::vector<u64>& numbers = control.numbers;
  const auto row = [&](std::size_t k) { return static_cast<u32>(numbers[k]); };
  const auto place = [&](std::size_t k) {
    return row(k) < image.files.size ? SourceLine{row(k), row(k + 1), row(k + 2)} : SourceLine{};
  };
  return FaultOfStep{
      numbers[0],
      numbers[1],
      {static_cast<FaultCode>(std::min<u64>(numbers[2], static_cast<u64>(FaultCode::UntriedDraw))),
       row(3) < image.atoms.size ? row(3) : kNone, row(4) < image.connectors.size ? row(4) : kNone, row(5), place(6),
       place(9), control.texts[0], control.texts[1], control.texts[2], control.texts[3]}};
}

}  // namespace bip::rt
