// Statistics of a run: see run_statistics.hpp.
#include "runtime/engine/run_statistics.hpp"

namespace bip::rt {

void print_run_statistics(std::FILE* err, const Core& core, const EnabledSizes& sizes, std::uint64_t steps,
                          double seconds, double cpu_seconds) {
  const double scale = steps == 0 ? 0 : 1e9 / static_cast<double>(steps);
  std::fprintf(err, "steps %llu, seconds %.6f, ns/step %.1f, CPU ns/step %.1f\n",
               static_cast<unsigned long long>(steps), seconds, seconds * scale, cpu_seconds * scale);
  if (sizes.samples != 0) {
    std::fprintf(err, "enabled %.1f on average, %llu to %llu, in %llu states\n",
                 static_cast<double>(sizes.sum) / static_cast<double>(sizes.samples),
                 static_cast<unsigned long long>(sizes.least), static_cast<unsigned long long>(sizes.most),
                 static_cast<unsigned long long>(sizes.samples));
  }
  if (const SearchWork& work = core.search().work(); work.searches != 0) {
    std::fprintf(err,
                 "searches of maximal interactions %llu, configurations looked at %llu, connectors evaluated %llu, "
                 "sets looked at as ranges %llu\n",
                 static_cast<unsigned long long>(work.searches), static_cast<unsigned long long>(work.configurations),
                 static_cast<unsigned long long>(work.connectors), static_cast<unsigned long long>(work.range_looks));
  }
  const MemoryUse use = core.memory();
  const auto per_row = [](u64 bytes, std::size_t rows) {
    return rows == 0 ? 0.0 : static_cast<double>(bytes) / static_cast<double>(rows);
  };
  std::fprintf(err, "bytes %.1f an atom beside its data, %.1f a connector; %llu in all, of them %llu data\n",
               per_row(use.atoms, core.image().atoms.size),
               per_row(use.connectors, core.image().connectors.size + core.tables().interactions.size() -
                                           core.tables().connector_interactions),
               static_cast<unsigned long long>(use.all()), static_cast<unsigned long long>(use.data));
}

}  // namespace bip::rt
