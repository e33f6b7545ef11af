// A script: the commands of --do and --script, one after the other, and what the next one waits for.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "editor/command.h"

namespace fjell::editor {

// A command of --do or --script, or what is wrong with it.
struct ScriptLine {
    std::optional<Command> command;
    std::string problem;
};

class Script {
public:
    // file: of commands, one a line; "-": standard input; empty: none. Throws io::Failure where it cannot be read.
    void read(const std::vector<std::string>& commands, const std::string& file);
    void put_first(Command command) { lines_.insert(lines_.begin(), {std::move(command), {}}); }
    [[nodiscard]] bool empty() const { return lines_.empty(); }
    // Lines are left, or something is waited for.
    [[nodiscard]] bool goes_on(std::uint64_t frame) const {
        return at_ < lines_.size() || waits_settled_ || frame < wait_until_frame_;
    }
    // The next line; null: not in this frame. settled: all that was asked for is done.
    const ScriptLine* next(std::uint64_t frame, const std::function<bool()>& settled);
    void wait_until(std::uint64_t frame, bool settled = false) {
        wait_until_frame_ = frame;
        waits_settled_ = settled;
    }
    // Nothing is left and nothing waited for.
    [[nodiscard]] bool over(std::uint64_t frame, bool settled) const {
        return at_ == lines_.size() && frame >= wait_until_frame_ && (!waits_settled_ || settled);
    }

private:
    std::vector<ScriptLine> lines_;
    std::size_t at_ = 0;
    std::uint64_t wait_until_frame_ = 0;
    bool waits_settled_ = false;
};

} // namespace fjell::editor
