// A bounded queue between two threads: block when full (replay) or drop the oldest (live).
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <stop_token>
#include <utility>

namespace touchline::base {

enum class FullPolicy { kBlock, kDropOldest };

template <typename T>
class BoundedQueue {
 public:
  BoundedQueue(std::size_t capacity, FullPolicy policy) : capacity_(capacity), policy_(policy) {}

  // False when the queue is closed or the stop was requested before there was room; the item is
  // then not taken.
  bool push(T item, std::stop_token stop = {}) {
    std::unique_lock lock(mutex_);
    if (policy_ == FullPolicy::kBlock) {
      changed_.wait(lock, stop, [&] { return closed_ || items_.size() < capacity_; });
      if (stop.stop_requested() && items_.size() >= capacity_) return false;
    }
    if (closed_) return false;
    if (items_.size() >= capacity_) {
      items_.pop_front();
      ++dropped_;
    }
    items_.push_back(std::move(item));
    lock.unlock();
    changed_.notify_all();
    return true;
  }

  // The next item; nothing once the queue is closed and empty, or when the stop is requested.
  std::optional<T> pop(std::stop_token stop = {}) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, stop, [&] { return closed_ || !items_.empty(); });
    if (items_.empty()) return std::nullopt;
    std::optional<T> item(std::move(items_.front()));
    items_.pop_front();
    lock.unlock();
    changed_.notify_all();
    return item;
  }

  // No more items come; those inside are still handed out.
  void close() {
    {
      const std::lock_guard lock(mutex_);
      closed_ = true;
    }
    changed_.notify_all();
  }

  std::size_t size() const {
    const std::lock_guard lock(mutex_);
    return items_.size();
  }
  // Items thrown away by kDropOldest since construction.
  std::uint64_t dropped() const {
    const std::lock_guard lock(mutex_);
    return dropped_;
  }

 private:
  const std::size_t capacity_;
  const FullPolicy policy_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<T> items_;
  std::uint64_t dropped_ = 0;
  bool closed_ = false;
};

}  // namespace touchline::base
