// The objects of FFI results: one a call and thread, made once, destroyed together.
#include "compiler/lower/results.hpp"

#include <catch2/catch.hpp>
#include <mutex>
#include <set>
#include <thread>
#include <vector>

namespace bip::lower {
namespace {

struct Counted {
  static inline int alive = 0;
  int value = 0;
  Counted() { ++alive; }
  Counted(const Counted& other) : value(other.value) { ++alive; }
  Counted& operator=(const Counted&) = default;
  ~Counted() { --alive; }
};

TEST_CASE("a call's FFI result stands in the same object each time, another call's in another one") {
  const rt::FfiType type = rt::ffi_type_of<Counted>("Counted");
  Results results;
  rt::Cell* first = results.cell(3, type);
  rt::object_in<Counted>(*first).value = 7;
  for (std::uint32_t other = 4; other < 100; ++other) CHECK(results.cell(other, type) != first);
  CHECK(results.cell(3, type) == first);
  CHECK(rt::object_in<Counted>(*results.cell(3, type)).value == 7);
  CHECK(Counted::alive == 97);
}

TEST_CASE("threads that make the same call at a time have an object each") {
  const rt::FfiType type = rt::ffi_type_of<Counted>("Counted");
  {
    Results results;
    std::set<const void*> objects;
    std::mutex lock;
    std::vector<std::thread> threads;
    std::uint32_t at_work = 4;
    for (std::uint32_t k = 0; k < 4; ++k) {
      threads.emplace_back([&] {
        const void* object = &rt::object_in<Counted>(*results.cell(3, type));
        std::unique_lock guard(lock);
        objects.insert(object);
        --at_work;
        // A thread that ended could hand its name on.
        while (at_work != 0) {
          guard.unlock();
          std::this_thread::yield();
          guard.lock();
        }
      });
    }
    for (std::thread& thread : threads) thread.join();
    CHECK(objects.size() == 4);
    CHECK(Counted::alive == 4);
  }
  CHECK(Counted::alive == 0);
}

}  // namespace
}  // namespace bip::lower
