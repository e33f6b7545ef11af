#include "host/failure.h"

#include <csignal>
#include <new>

#include <fmt/format.h>

namespace fjell::host {

namespace {
volatile std::sig_atomic_t interrupted = 0;
void on_signal(int) {
    interrupted = 1;
}

int say(const char* name, int code, std::string text) {
    for (char& c : text)
        if (c == '\n') c = ' '; // one line, whatever a library said
    fmt::print(stderr, "{}: {}\n", name, text);
    return code;
}
} // namespace

int run_tool(const char* name, const std::function<int()>& body) {
    std::signal(SIGXFSZ, SIG_IGN); // a file-size limit is a write error like any other
    std::signal(SIGPIPE, SIG_IGN);
    try {
        return body();
    } catch (const Failure& failure) {
        return say(name, failure.exit_code, failure.what());
    } catch (const std::bad_alloc&) {
        return say(name, 3, "out of memory; take a smaller height field or smaller budgets");
    } catch (const std::exception& error) {
        return say(name, 3, fmt::format("internal error: {}", error.what()));
    }
}

void catch_interrupts() {
    std::signal(SIGINT, on_signal);
    std::signal(SIGTERM, on_signal);
}

void check_interrupt() {
    if (interrupted) throw Failure(130, "interrupted; nothing half-written is left");
}

} // namespace fjell::host
