#include "baker/cli/progress.h"

#include <cstdio>
#include <unistd.h>

#include <fmt/format.h>

#include "fjell/io/failure.h"

namespace fjell::baker {

namespace {
constexpr int bar_cells = 30;
}

ProgressBar::ProgressBar(bool quiet) : draws_(!quiet && isatty(STDERR_FILENO)) {}

ProgressBar::~ProgressBar() {
    if (drawn_) std::fputs("\r\033[K", stderr);
}

void ProgressBar::operator()(const char* stage, std::uint64_t done, std::uint64_t total) {
    io::check_interrupt();
    if (!draws_ || total == 0) return;
    const auto now = std::chrono::steady_clock::now();
    if (stage_ != stage) {
        stage_ = stage;
        start_ = now;
        last_ = {};
    }
    if (done < total && now - last_ < std::chrono::milliseconds(50)) return;
    last_ = now;
    drawn_ = true;
    const double elapsed = std::chrono::duration<double>(now - start_).count();
    const double share = static_cast<double>(done) / static_cast<double>(total);
    const double rate = elapsed > 0 ? static_cast<double>(done) / elapsed : 0;
    const auto full = static_cast<std::size_t>(share * bar_cells);
    const std::string bar = std::string(full, '#') + std::string(bar_cells - full, '.');
    const double left = rate > 0 ? static_cast<double>(total - done) / rate : 0;
    const std::string speed = rate >= 1e6 ? fmt::format("{:.1f} M/s", rate / 1e6) : fmt::format("{:.0f} /s", rate);
    fmt::print(stderr, "\r\033[K{:<8} [{}] {:3.0f}%  {}  {:.0f} s left", stage, bar, share * 100, speed, left);
    std::fflush(stderr);
}

} // namespace fjell::baker
