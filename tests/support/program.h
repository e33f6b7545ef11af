// Running the built programs as a shell would.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <sys/wait.h>

namespace fjell::test {

inline std::string slurp(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
}
inline void spit(const std::filesystem::path& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
}

struct Run {
    int code = -1; // 128 + the signal's number when one ended it
    std::string out, err;
};

// Runs a command in a folder; its output is kept elsewhere, so the folder shows what the command left.
inline Run run_in(const std::filesystem::path& folder, const std::string& command) {
    std::string name = (std::filesystem::temp_directory_path() / "fjell-run-XXXXXX").string();
    const std::filesystem::path aside = mkdtemp(name.data());
    const std::string to = " >'" + (aside / "out").string() + "' 2>'" + (aside / "err").string() + "'";
    const int status = std::system(("cd '" + folder.string() + "' && (" + command + ")" + to).c_str());
    Run result{WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), slurp(aside / "out"),
               slurp(aside / "err")};
    std::filesystem::remove_all(aside);
    return result;
}

// Before a command whose pictures nobody looks at: Mesa's software renderer then does all but fill pixels, which is
// most of what a frame costs it. Other drivers do not know the word, and draw.
inline const std::string no_pixels = "LP_NO_RAST=1 ";

// For a command line: waits until the process $p is one of our programs and catches these signals (a bit each, from
// SIGHUP, 1), or has ended. A signal that comes before that ends a program without a word, which on a busy machine may
// be seconds later; and before exec() the mask is the shell's, which catches SIGINT itself.
inline std::string until_caught(unsigned signals) {
    const std::string mask = std::to_string(signals);
    return "until { grep -q ^fjell /proc/$p/comm 2>/dev/null && [ $((0x0$(sed -n 's/^SigCgt:[[:space:]]*//p' "
           "/proc/$p/status 2>/dev/null) & " +
           mask + ")) = " + mask + " ]; } || ! kill -0 $p 2>/dev/null; do sleep 0.01; done; ";
}

} // namespace fjell::test
