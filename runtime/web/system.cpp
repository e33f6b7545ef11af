// What stands below the module: memory for JavaScript, the clock, and exceptions, which become JavaScript's.
#include <cstdlib>
#include <ctime>
#include <exception>
#include <new>
#include <typeinfo>

#include "calls.h"
#include "fjell/io/failure.h"
#include "fjell/version.h"
#include "io/stop_flag.h"

extern "C" {
[[noreturn]] __attribute__((import_module("fjell"), import_name("fail"))) void fjell_fail(const char* text);
__attribute__((import_module("fjell"), import_name("now_ms"))) double fjell_now_ms();
}

// Nobody interrupts a call: a worker that is stopped is gone (runtime/io/failure.cpp has these elsewhere).
namespace fjell::io {
void check_interrupt() {}
const std::atomic<bool>* stop_flag() {
    return nullptr;
}
void set_stop_flag(const std::atomic<bool>*) {}
} // namespace fjell::io

namespace fjell::web {

double numbers[512];

void fail(const std::string& text) {
    fjell_fail(text.c_str());
}

void require(const Status& status, const char* where) {
    if (!status.ok())
        fail(std::string(where) + ": " + (*status.field ? std::string(status.field) + ": " : "") +
             message(status.code));
}

FJELL_CALL double* web_numbers() {
    return numbers;
}
FJELL_CALL const char* web_version() {
    return FJELL_VERSION_STRING;
}
FJELL_CALL void* web_allocate(std::size_t bytes) {
    void* const memory = std::aligned_alloc(64, (bytes + 63) / 64 * 64);
    if (memory == nullptr) fail("out of memory: WebAssembly has 4 GB at most; take smaller budgets or heights");
    return memory;
}
FJELL_CALL void web_free(void* memory) {
    std::free(memory);
}

} // namespace fjell::web

// Instead of libc++abi's: the module is left at once, and nothing is unwound.
extern "C" void* __cxa_allocate_exception(std::size_t bytes) noexcept {
    return std::malloc(bytes);
}
extern "C" __attribute__((noreturn)) void __cxa_throw(void* thrown, std::type_info*, void (*)(void*)) {
    fjell_fail(static_cast<const std::exception*>(thrown)->what());
}

// Instead of WASI's, whose 64-bit arguments are objects in JavaScript: garbage in every frame.
extern "C" int clock_gettime(clockid_t, timespec* now) {
    const double ms = fjell_now_ms();
    now->tv_sec = static_cast<time_t>(ms / 1e3);
    now->tv_nsec = static_cast<long>((ms - static_cast<double>(now->tv_sec) * 1e3) * 1e6);
    return 0;
}
