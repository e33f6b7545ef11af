#include "editor/script.h"

#include <iostream>
#include <iterator>
#include <sstream>
#include <utility>

#include "fjell/io/failure.h"
#include "io/file.h"

namespace fjell::editor {

void Script::read(const std::vector<std::string>& commands, const std::string& file) {
    const auto add = [&](const std::string& line, const std::string& where) {
        try {
            if (auto command = parse_command(line)) lines_.push_back({std::move(command), {}});
        } catch (const io::Failure& failure) {
            lines_.push_back({{}, where + ": " + failure.what()});
        }
    };
    for (const std::string& line : commands) add(line, "--do");
    if (file.empty()) return;
    std::string text;
    if (file == "-")
        text.assign(std::istreambuf_iterator<char>(std::cin), {});
    else
        text = io::read_text(file);
    std::istringstream lines(text);
    int number = 0;
    for (std::string line; std::getline(lines, line);) add(line, file + ":" + std::to_string(++number));
}

const ScriptLine* Script::next(std::uint64_t frame, const std::function<bool()>& settled) {
    if (at_ == lines_.size() || frame < wait_until_frame_ || (waits_settled_ && !settled())) return nullptr;
    waits_settled_ = false;
    return &lines_[at_++];
}

} // namespace fjell::editor
