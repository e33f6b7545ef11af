#include "fjell/io/failure.h"

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <new>
#include <system_error>

#include "io/stop_flag.h"
#include "io/system.h"

namespace fjell::io {

namespace {
volatile std::sig_atomic_t interrupted = 0;
thread_local const std::atomic<bool>* flag_of_thread = nullptr;
// Asked again and again, it no longer waits for the next check. (Wrappers such as timeout(1) send a signal twice.)
constexpr int patience = 3;
void on_signal(int) {
    interrupted = interrupted + 1;
    if (interrupted > patience) std::_Exit(130);
}

int say(const char* name, int code, std::string text) {
    for (char& c : text)
        if (static_cast<unsigned char>(c) < ' ' || c == 0x7f) c = ' '; // one line, whatever a file or a library said
    text = std::string(name) + ": " + text + "\n";
    (void)std::fputs(text.c_str(), stderr); // whether anyone can hear it or not
    return code;
}
} // namespace

Failure as_failure(const std::exception& thrown) {
    if (const auto* const failure = dynamic_cast<const Failure*>(&thrown)) return *failure;
    if (dynamic_cast<const std::bad_alloc*>(&thrown) != nullptr ||
        dynamic_cast<const std::length_error*>(&thrown) != nullptr)
        return {3, "out of memory; close other programs, or take smaller budgets or a smaller height field"};
    if (const auto* const disk = dynamic_cast<const std::filesystem::filesystem_error*>(&thrown))
        return {3, os::text_of(disk->path1()) + ": " + disk->code().message() +
                       "; check the path and who may write there"};
    if (const auto* const system = dynamic_cast<const std::system_error*>(&thrown))
        return {3, system->code().message() + "; close other programs, or raise the machine's limits"};
    return {3, std::string("internal error, please report it: ") + thrown.what()};
}

int run_tool(const char* name, const std::function<int()>& body) {
    os::ignore_write_signals();
    try {
        const int code = body();
        if (code == 0 && (std::fflush(stdout) != 0 || std::ferror(stdout)))
            return say(name, 3, "cannot write to the standard output; free some space or send it elsewhere");
        return code;
    } catch (const std::exception& thrown) {
        const Failure failure = as_failure(thrown);
        return say(name, failure.exit_code, failure.what());
    }
}

void catch_interrupts() {
    for (const int number : os::stop_signals()) std::signal(number, on_signal);
}

const std::atomic<bool>* stop_flag() {
    return flag_of_thread;
}
void set_stop_flag(const std::atomic<bool>* flag) {
    flag_of_thread = flag;
}

void check_interrupt() {
    if (interrupted || (flag_of_thread && *flag_of_thread))
        throw Failure(130, "interrupted; files that were finished stay, nothing half-written does");
}

} // namespace fjell::io
