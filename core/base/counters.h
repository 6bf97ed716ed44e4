// Counts entries into code that a scene may leave out. Only the build with sanitizers has them.
#pragma once

#include <atomic>
#include <cstdint>

namespace tilecast::counters {

#ifdef TILECAST_COUNTERS
inline std::atomic<uint64_t> csg{0}, solid{0}, mesh{0}, group{0}, shadow{0}, medium{0}, texture{0};
#define TILECAST_COUNT(name) ::tilecast::counters::name.fetch_add(1, std::memory_order_relaxed)
#else
#define TILECAST_COUNT(name) ((void)0)
#endif

}  // namespace tilecast::counters
