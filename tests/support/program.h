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
    char name[] = "/tmp/fjell-run-XXXXXX";
    const std::filesystem::path aside = mkdtemp(name);
    const std::string to = " >'" + (aside / "out").string() + "' 2>'" + (aside / "err").string() + "'";
    const int status = std::system(("cd '" + folder.string() + "' && (" + command + ")" + to).c_str());
    Run result{WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), slurp(aside / "out"),
               slurp(aside / "err")};
    std::filesystem::remove_all(aside);
    return result;
}

} // namespace fjell::test
