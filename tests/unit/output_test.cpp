// Files that programs write: replaced whole, with what they were otherwise, and never over what is still to be read.
#include <catch2/catch.hpp>

#include <csignal>
#include <filesystem>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "fjell/io/failure.h"
#include "io/file.h"
#include "support/program.h"
#include "support/temporary_folder.h"

using namespace fjell;
using namespace fjell::test;

namespace {

void append_text(io::AtomicFile& file, const std::string& text) {
    file.write(std::as_bytes(std::span(text)));
}
void replace_file(const std::string& path, const std::string& text) {
    io::AtomicFile file(path);
    append_text(file, text);
    file.commit();
}

struct stat file_status(const std::string& path) {
    struct stat info {};
    REQUIRE(stat(path.c_str(), &info) == 0);
    return info;
}

// What refuse_overwriting() says; empty: nothing.
std::string overwriting_refused(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs) {
    try {
        io::refuse_overwriting(outputs, inputs);
    } catch (const io::Failure& failure) {
        CHECK(failure.exit_code == 2);
        return failure.what();
    }
    return {};
}

} // namespace

TEST_CASE("a file that is replaced keeps its mode, its owner and the links to it") {
    const TemporaryFolder folder;
    const std::string file = folder / "real", link = folder / "link";
    spit(file, "old");
    std::filesystem::create_symlink("real", link);
    REQUIRE(chmod(file.c_str(), 0640) == 0);
    const bool root = geteuid() == 0;
    if (root) REQUIRE(chown(file.c_str(), 1234, 4321) == 0);
    replace_file(link, "new");
    CHECK(slurp(file) == "new");
    CHECK(std::filesystem::is_symlink(link));
    CHECK((file_status(file).st_mode & 07777) == 0640);
    if (root) CHECK(file_status(file).st_uid == 1234);
    if (root) CHECK(file_status(file).st_gid == 4321);
    const mode_t mask = umask(027);
    replace_file(folder / "fresh", "new");
    umask(mask);
    CHECK((file_status(folder / "fresh").st_mode & 07777) == 0640);
    CHECK(folder.names() == std::vector<std::string>{"fresh", "link", "real"});
}

TEST_CASE("what a killed program has left beside an output, the next one that writes it removes") {
    const TemporaryFolder folder;
    const std::string file = folder / "out";
    spit(file, "old");
    const pid_t child = fork();
    if (child == 0) {
        const io::AtomicFile one(file), another(file); // as of two programs
        raise(SIGKILL);
    }
    int status = 0;
    REQUIRE(waitpid(child, &status, 0) == child);
    CHECK(slurp(file) == "old");
    CHECK(folder.names().size() == 3);
    replace_file(file, "new");
    CHECK(slurp(file) == "new");
    CHECK(folder.names() == std::vector<std::string>{"out"});
}

TEST_CASE("programs that write the same output at once do not disturb each other") {
    const TemporaryFolder folder;
    const std::string file = folder / "out";
    io::AtomicFile first(file), second(file);
    append_text(first, "first");
    append_text(second, "second");
    { const io::AtomicFile abandoned(file); }
    second.commit();
    CHECK(slurp(file) == "second");
    first.commit();
    CHECK(slurp(file) == "first");
    CHECK(folder.names() == std::vector<std::string>{"out"});
}

TEST_CASE("a link under a temporary file's name is not followed") {
    const TemporaryFolder folder;
    spit(folder / "precious", "years of work");
    std::filesystem::create_symlink("precious", folder / "out.fjell-tmp");
    replace_file(folder / "out", "new");
    CHECK(slurp(folder / "out") == "new");
    CHECK(slurp(folder / "precious") == "years of work");
}

TEST_CASE("a pipe is written as it is") {
    const TemporaryFolder folder;
    const std::string pipe = folder / "pipe";
    REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
    std::string read;
    std::thread reader([&] { read = slurp(pipe); });
    replace_file(pipe, "rows");
    reader.join();
    CHECK(read == "rows");
    CHECK(S_ISFIFO(file_status(pipe).st_mode));
    CHECK(folder.names() == std::vector<std::string>{"pipe"});
}

TEST_CASE("outputs are told from inputs and from each other by what they are, not by their names") {
    const TemporaryFolder folder;
    spit(folder / "in", "heights");
    std::filesystem::create_symlink("in", folder / "soft");
    std::filesystem::create_hard_link(folder / "in", folder / "hard");
    std::filesystem::create_symlink("later", folder / "dangling");
    std::filesystem::create_directory(folder / "work");
    spit(folder / "work/part", "");
    const std::string in = folder / "in";
    for (const char* name : {"in", "soft", "hard", "../in", "work/../in"}) {
        const std::string path = name[0] == '.' ? folder / ("work/" + std::string(name)) : folder / name;
        CHECK(overwriting_refused({path}, {in}).find("would overwrite the input " + in) != std::string::npos);
    }
    CHECK(overwriting_refused({folder / "out"}, {in}).empty());
    CHECK(overwriting_refused({folder / "dangling", folder / "later"}, {in}).find("the output") != std::string::npos);
    CHECK(!overwriting_refused({folder / "work/"}, {folder / "work/part"}).empty());
    CHECK(overwriting_refused({folder / "work/"}, {folder / "works"}).empty());
    CHECK(overwriting_refused({"-", "-", "/dev/null", "/dev/null", "", ""}, {"", "/dev/null"}).empty());
}
