// Where slow work runs: in the background when live, at once in replay, so that a replay gives the
// same bytes every time.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <stop_token>
#include <thread>
#include <type_traits>
#include <utility>

namespace touchline::runtime {

// A move-only void(std::stop_token) or void(). It must not throw.
class Task {
 public:
  Task() = default;
  template <typename F>
  requires(!std::is_same_v<std::remove_cvref_t<F>, Task>) Task(F&& function)
      : body_(std::make_unique<Body<std::decay_t<F>>>(std::forward<F>(function))) {}

  void operator()(std::stop_token stop) { body_->run(std::move(stop)); }
  explicit operator bool() const { return body_ != nullptr; }

 private:
  struct Base {
    virtual ~Base() = default;
    virtual void run(std::stop_token stop) = 0;
  };
  template <typename F>
  struct Body final : Base {
    template <typename G>
    explicit Body(G&& f) : function(std::forward<G>(f)) {}
    void run(std::stop_token stop) override {
      if constexpr (std::is_invocable_v<F&, std::stop_token>) {
        function(std::move(stop));
      } else {
        function();
      }
    }
    F function;
  };
  std::unique_ptr<Base> body_;
};

class Executor {
 public:
  virtual ~Executor() = default;
  // False when the task was not taken: too many wait already, or the executor is stopping.
  virtual bool post(Task task) = 0;
  // Returns when every task taken so far has run or has been dropped by a stop.
  virtual void drain() = 0;
};

// Runs the task inside post(), on the caller's thread.
class InlineExecutor final : public Executor {
 public:
  bool post(Task task) override;
  void drain() override {}
};

// One thread; tasks run in the order they came. Destruction asks the running task to stop, drops
// those that wait and joins.
class BackgroundExecutor final : public Executor {
 public:
  // At most `capacity` tasks wait, besides the one that runs; at least 1.
  explicit BackgroundExecutor(std::size_t capacity);
  ~BackgroundExecutor() override;
  BackgroundExecutor(const BackgroundExecutor&) = delete;
  BackgroundExecutor& operator=(const BackgroundExecutor&) = delete;

  bool post(Task task) override;
  void drain() override;

 private:
  void run(std::stop_token stop);

  const std::size_t capacity_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<Task> waiting_;
  bool running_ = false;
  bool stopping_ = false;
  std::jthread thread_;
};

}  // namespace touchline::runtime
