// Runs a stream of jobs on several threads and delivers the results in order.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

namespace kasumi {

// next: called by one worker at a time until it returns nothing; it may block (a list that is still being written)
// without delaying jobs in progress. work: called in the workers with the worker's index (0 .. threads-1). done: called
// in order, one at a time, from any worker. At most about 4 x threads results wait for an earlier one.
template <class Job, class Answer>
void run_in_order(std::size_t threads, const std::function<std::optional<Job>()>& next,
                  const std::function<Answer(std::size_t worker, const Job&)>& work,
                  const std::function<void(const Job&, const Answer&)>& done) {
  std::mutex input;  // guards next() and taken
  std::size_t taken = 0;
  bool over = false;
  std::mutex results;  // guards the rest
  std::condition_variable room;
  std::map<std::size_t, std::pair<Job, Answer>> waiting;
  std::size_t finished = 0;
  const std::size_t most_ahead = 4 * threads;

  const auto worker = [&](std::size_t index) {
    for (;;) {
      std::unique_lock in(input);
      if (over) return;
      auto job = next();
      if (!job) {
        over = true;
        return;
      }
      const std::size_t number = taken++;
      in.unlock();
      auto answer = work(index, *job);
      std::unique_lock out(results);
      room.wait(out, [&] { return number - finished < most_ahead; });
      waiting.emplace(number, std::pair{std::move(*job), std::move(answer)});
      while (!waiting.empty() && waiting.begin()->first == finished) {
        auto first = waiting.extract(waiting.begin());
        done(first.mapped().first, first.mapped().second);
        ++finished;
      }
      room.notify_all();
    }
  };

  std::vector<std::thread> workers;
  for (std::size_t i = 0; i + 1 < threads; ++i) workers.emplace_back(worker, i + 1);
  worker(0);
  for (auto& thread : workers) thread.join();
}

}  // namespace kasumi
