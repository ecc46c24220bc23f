// Work shared by threads.
#pragma once

#include <algorithm>
#include <cstddef>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace gsp {

// Runs `work` on up to `jobs` threads, this one among them, and no more than there are pieces of
// it. Each call of `work` takes pieces until all are taken, so fewer threads give the same result
// if the system refuses some. An exception of a call is thrown here, after all calls have ended.
template <class Work>
void share(int jobs, std::size_t pieces, const Work& work) {
  std::exception_ptr failure;
  std::mutex guard;
  const auto guarded = [&] {
    try {
      work();
    } catch (...) {
      const std::lock_guard<std::mutex> lock(guard);
      if (!failure) failure = std::current_exception();
    }
  };
  const std::size_t most = std::min(pieces, static_cast<std::size_t>(std::max(jobs, 1)));
  std::vector<std::thread> threads;
  threads.reserve(most);
  try {
    while (threads.size() + 1 < most) threads.emplace_back(guarded);
  } catch (const std::system_error&) {
    // The system refuses further threads.
  }
  guarded();
  for (std::thread& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace gsp
