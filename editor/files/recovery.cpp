#include "editor/files/recovery.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "editor/files/settings.h"
#include "fjell/io/failure.h"
#include "io/file.h"
#include "io/json.h"

namespace fjell::editor {

namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr double least_between_s = 2;

std::string lock_of(const std::string& file) {
    return file + ".lock";
}

// -1: another one has it, or it cannot be made.
int locked(const std::string& file) {
    const int fd = io::uninterrupted([&] { return open(lock_of(file).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600); });
    if (fd >= 0 && flock(fd, LOCK_EX | LOCK_NB) == 0) return fd;
    if (fd >= 0) close(fd);
    return -1;
}

// The lock's file goes first, while it is held: who waits for it opens another.
void unlock(const std::string& file, int& fd) {
    if (fd < 0) return;
    unlink(lock_of(file).c_str());
    close(std::exchange(fd, -1));
}

std::uint64_t hash_of(const Route& route) {
    std::uint64_t hash = 14695981039346656037u; // FNV-1a, by words
    if (!route.unsaved()) return 0;
    const auto add = [&](double value) {
        std::uint64_t bits = 0;
        std::memcpy(&bits, &value, sizeof bits);
        hash = (hash ^ bits) * 1099511628211u;
    };
    for (const session::ControlPoint& point : route.points())
        for (const double value : point) add(value);
    add(route.requested_seconds());
    return hash;
}

Unsaved parse(const std::string& text) {
    const json j = io::parse_json(text, "recovery");
    Unsaved u;
    u.path = j.at("path").get<std::string>();
    u.pack = j.at("pack").get<std::string>();
    u.profile_changed = j.at("profile_changed").get<bool>();
    u.profile = parse_profile(j.at("profile").get<std::string>(), "profile");
    for (const json& point : j.at("points")) u.points.push_back(point.get<session::ControlPoint>());
    u.path_seconds = std::clamp(j.value("path_seconds", 0.0), 0.0, session::max_path_seconds);
    return u;
}

// Not AtomicFile: that waits until the disk has it, which no frame can.
void write_quickly(const std::string& file, const std::string& text) {
    const std::string temporary = file + ".tmp";
    const int fd =
        io::uninterrupted([&] { return open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600); });
    if (fd < 0) io::disk_failure(temporary, "open");
    try {
        io::write_all(fd, 0, std::as_bytes(std::span(text)), temporary);
    } catch (const io::Failure&) {
        close(fd);
        unlink(temporary.c_str());
        throw;
    }
    close(fd);
    if (std::rename(temporary.c_str(), file.c_str()) != 0) io::disk_failure(file, "rename");
}

// Of an editor that was killed: what it was just writing, and the lock of what it never wrote.
void remove_leftovers(const std::vector<std::string>& names) {
    for (const std::string& name : names) {
        const std::string file = name.substr(0, name.rfind('.'));
        std::error_code ignored;
        if (name.ends_with(".lock") && fs::exists(file, ignored)) continue;
        int lock = locked(file);
        if (lock < 0) continue; // it is alive
        unlink((file + ".tmp").c_str());
        unlock(file, lock);
    }
}

} // namespace

Recovery::~Recovery() {
    if (lock_ >= 0) close(lock_);
    if (found_lock_ >= 0) close(found_lock_);
}

void Recovery::report_once(std::string problem) {
    if (std::exchange(reported_, true)) return;
    problem_ = std::move(problem);
}

std::string Recovery::take_problem() {
    return std::exchange(problem_, {});
}

// False: another one has it, or it is none.
bool Recovery::take(const std::string& file) {
    const int lock = locked(file);
    if (lock < 0) return false;
    found_file_ = file;
    found_lock_ = lock;
    std::error_code gone;
    if (fs::exists(file, gone)) { // nobody took it before it was locked
        try {
            found_ = parse(io::read_text(file));
            return true;
        } catch (const std::exception&) {
            fs::rename(file, file + ".damaged", gone);
            report_once(fmt::format("{}: damaged recovery file of an earlier run; kept as {}.damaged", file, file));
        }
    }
    unlock(found_file_, found_lock_);
    return false;
}

void Recovery::find(const std::string& folder) {
    found_folder_ = folder;
    if (folder.empty()) return;
    std::vector<std::pair<fs::file_time_type, std::string>> files;
    std::vector<std::string> leftovers;
    std::error_code error;
    for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
        const std::string name = at->path().filename().string();
        if (name.starts_with("unsaved-") && name.ends_with(".json") && at->path().string() != file_)
            files.emplace_back(at->last_write_time(error), at->path().string());
        if (name.starts_with("unsaved-") && (name.ends_with(".json.tmp") || name.ends_with(".json.lock")))
            leftovers.push_back(at->path().string());
    }
    remove_leftovers(leftovers);
    std::ranges::sort(files, std::greater{});
    for (const auto& [time, file] : files)
        if (take(file)) return;
}

void Recovery::drop_found() {
    if (!found_) return;
    found_.reset();
    unlink(found_file_.c_str());
    unlock(found_file_, found_lock_);
    find(found_folder_);
}

void Recovery::make_file() {
    std::error_code ignored; // what is wrong with the folder, the file says
    fs::create_directories(folder_, ignored);
    for (int n = 0; n < 1000; ++n) { // a process of that number may have left one before
        std::string file = fmt::format("{}/unsaved-{}-{}.json", folder_, getpid(), n);
        if (fs::exists(file, ignored)) continue;
        lock_ = locked(file);
        if (lock_ < 0) continue;
        file_ = std::move(file);
        return;
    }
    throw io::Failure(3, fmt::format("{}: cannot write there; choose another XDG_STATE_HOME", folder_));
}

void Recovery::write(const Document& document, const Route& route, const std::string& pack) {
    try {
        if (file_.empty()) make_file();
        json j = {{"path", document.path()},
                  {"pack", pack},
                  {"profile_changed", document.unsaved()},
                  {"profile", profile_text(document.profile(), document.heading())},
                  {"points", json::array()}};
        if (route.unsaved()) {
            j["points"] = route.points();
            j["path_seconds"] = route.requested_seconds();
        }
        write_quickly(file_, j.dump(1, ' ', false, json::error_handler_t::replace) + "\n");
    } catch (const std::exception& failure) {
        report_once(fmt::format("changes would not survive a crash; save often: {}", failure.what()));
    }
}

void Recovery::keep(const Document& document, const Route& route, const std::string& pack, double now_s) {
    if (folder_.empty() || now_s - written_s_ < least_between_s) return;
    const std::uint64_t hash = hash_of(route);
    if (version_ == document.version() && points_hash_ == hash) return;
    version_ = document.version();
    points_hash_ = hash;
    if (!document.unsaved() && !route.unsaved()) {
        remove();
        return;
    }
    written_s_ = now_s;
    write(document, route, pack);
}

void Recovery::keep_now(const Document& document, const Route& route, const std::string& pack) {
    if (folder_.empty()) return;
    if (document.unsaved() || route.unsaved())
        write(document, route, pack);
    else
        remove();
}

void Recovery::remove() {
    if (file_.empty()) return;
    unlink(file_.c_str());
    unlock(file_, lock_);
    file_.clear();
}

} // namespace fjell::editor
