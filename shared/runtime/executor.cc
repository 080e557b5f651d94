#include "shared/runtime/executor.h"

#include <algorithm>

namespace touchline::runtime {

bool InlineExecutor::post(Task task) {
  task(std::stop_token{});
  return true;
}

BackgroundExecutor::BackgroundExecutor(std::size_t capacity)
    : capacity_(std::max<std::size_t>(capacity, 1)),
      thread_([this](std::stop_token stop) { run(std::move(stop)); }) {}

BackgroundExecutor::~BackgroundExecutor() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    waiting_.clear();
  }
  thread_.request_stop();
  changed_.notify_all();
  thread_.join();
}

bool BackgroundExecutor::post(Task task) {
  {
    const std::lock_guard lock(mutex_);
    if (stopping_ || waiting_.size() >= capacity_) return false;
    waiting_.push_back(std::move(task));
  }
  changed_.notify_all();
  return true;
}

void BackgroundExecutor::drain() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return waiting_.empty() && !running_; });
}

void BackgroundExecutor::run(std::stop_token stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [&] { return !waiting_.empty(); })) {
    Task task = std::move(waiting_.front());
    waiting_.pop_front();
    running_ = true;
    lock.unlock();
    task(stop);
    task = Task();  // what it holds goes before drain() returns
    lock.lock();
    running_ = false;
    changed_.notify_all();
  }
}

}  // namespace touchline::runtime
