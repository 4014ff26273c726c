// SPDX-License-Identifier: MIT
#pragma once
/// The whole procedure: provoke, then for every load the empty loop and the scene, both for the same time.

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "validation/certificate/certificate.hpp"

namespace palpate::certificate {

/// What whoever waits may show; written by one thread, read by another.
struct Progress {
  std::atomic<const char*> stage{"beginning"};
  std::atomic<long> done{0};
  std::atomic<long> ticks{0};  ///< of this stage; 0: not known
};

struct CertifyPlan {
  Claim claim{};
  std::vector<std::string> loads{"idle"};
  std::size_t cache_bytes = 32U << 20U;      ///< of the largest cache
  std::vector<int> isolated{};               ///< processors that the system keeps free; the loop takes one
  std::optional<double> tissue_stiffness{};  ///< at the tool, at rest [N/m]; for a tool without a device
  int priority = 80;                         ///< of SCHED_FIFO
  bool ask_for_rights = true;                ///< false: as if the system had refused them
  const std::atomic<bool>* stop = nullptr;
  Progress* progress = nullptr;
  /// Times of the loop's processor and of all others since the start of the machine; empty: not known.
  std::function<ProcessorTimes(int processor)> processor_times{};
  /// A load that is not one of background_load.hpp, until what is returned is gone.
  std::function<std::shared_ptr<void>(const std::string& load, const std::vector<int>& processors)>
      outside_load{};
};

/// Changes affinity and scheduling of the calling thread: call it on one of its own. The scene must be able
/// to run at the claim's rate (why_not_at()).
Certificate certify(const Scene& scene, const CertifyPlan& plan);

}  // namespace palpate::certificate
