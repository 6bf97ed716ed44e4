// Arrays that are written once and read everywhere: on large pages where the system has them, from half a page on, which
// saves most of the misses of address translation; and not zeroed beforehand.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <new>
#include <vector>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace tilecast {

template <class T>
struct LargePages {
  using value_type = T;
  static constexpr size_t kPage = size_t(1) << 21;

  LargePages() = default;
  template <class U>
  LargePages(const LargePages<U>&) {}

  T* allocate(size_t count) {
    const size_t bytes = count * sizeof(T), alignment = bytes < kPage / 2 ? std::max(alignof(T), alignof(void*)) : kPage;
    void* at = std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
    if (!at) throw std::bad_alloc();
#ifdef __linux__
    if (alignment == kPage) madvise(at, (bytes + kPage - 1) / kPage * kPage, MADV_HUGEPAGE);  // advice: nothing is lost without
#endif
    return static_cast<T*>(at);
  }
  void deallocate(T* at, size_t) { std::free(at); }

  template <class U>
  void construct(U* at) {
    ::new (static_cast<void*>(at)) U;  // not zeroed
  }
  template <class U, class... Args>
  void construct(U* at, Args&&... args) {
    ::new (static_cast<void*>(at)) U(std::forward<Args>(args)...);
  }
  bool operator==(const LargePages&) const { return true; }
};

template <class T>
using LargeArray = std::vector<T, LargePages<T>>;

}  // namespace tilecast
