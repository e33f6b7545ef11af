#include "baker/shard/plan_folder.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <set>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <nlohmann/json.hpp>
#include <xxhash.h>

#include "io/file.h"
#include "io/json.h"

namespace fjell::baker {

namespace {

using nlohmann::json;
using nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr int plan_version = 1;

void write_text(const std::string& path, const std::string& text) {
    io::AtomicFile file(path);
    file.write(std::as_bytes(std::span(text)));
    file.commit();
}

std::string hex(std::uint64_t value) {
    return fmt::format("{:016x}", value);
}

struct Damaged {};

std::uint64_t from_hex(const json& value) {
    const std::string text = value.get<std::string>();
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, 16);
    if (error != std::errc() || end != text.data() + text.size()) throw Damaged();
    return number;
}

// By its content: times and names differ from machine to machine.
std::string this_program() {
    static const std::string name = [] {
        const std::vector<std::byte> bytes = io::read_file("/proc/self/exe");
        return hex(XXH3_64bits(bytes.data(), bytes.size()));
    }();
    return name;
}

std::uint64_t id_of(const std::string& plan, const std::string& recipe) {
    const std::string all = plan + '\n' + recipe;
    return XXH3_64bits(all.data(), all.size());
}

void make_folder(const std::string& path) {
    std::error_code error;
    fs::create_directories(path, error);
    if (!error) return;
    errno = error.value();
    io::disk_failure(path, "make the folder");
}

std::string plan_text(const ShardPlan& plan) {
    ordered_json j;
    j["fjell_plan"] = plan_version;
    j["program"] = plan.program;
    j["shards"] = plan.shards;
    j["rounds"] = plan.rounds;
    j["columns"] = plan.columns;
    j["rows"] = plan.rows;
    j["tile_log2"] = plan.tile_log2;
    if (plan.packs) j["packs"] = {plan.packs->packs_x, plan.packs->packs_y};
    j["parts"] = ordered_json::array();
    for (const Window& p : plan.parts) j["parts"].push_back({p.x, p.y, p.columns, p.rows});
    j["inputs"] = ordered_json::array();
    for (const ShardPlan::Input& input : plan.inputs)
        j["inputs"].push_back({{"file", input.path}, {"bytes", input.bytes}});
    return j.dump(1) + "\n";
}

std::string plan_path(const std::string& folder) {
    return folder + "/plan.json";
}
std::string recipe_path(const std::string& folder) {
    return folder + "/recipe.json";
}

} // namespace

ShardPlan make_shard_plan(const HeightSource& source, const BakeOptions& options, int shards,
                          const std::optional<SetGrid>& packs) {
    if (shards < 1 || shards > max_shards)
        throw Failure(2, fmt::format("--shards {}: must be from 1 to {}", shards, max_shards));
    ShardPlan plan;
    plan.shards = shards;
    plan.columns = source.columns;
    plan.rows = source.rows;
    plan.tile_log2 = options.tile_log2 ? options.tile_log2 : auto_tile_log2(source.columns, source.rows);
    const int mixed_log2 = plan.tile_log2 - page_squares_log2;
    if (options.order == PageOrder::linear || mixed_log2 < 1)
        throw Failure(2, "shards need tiles of 64 cells at least, and --order planar or hz; bake on one machine");
    plan.rounds = std::min(mixed_log2, most_rounds);
    const Tree tree = Tree::covering(plan.columns, plan.rows, plan.tile_log2);
    const Regions regions(tree, BakeOptions{}.region_cells);
    plan.parts = cut_into_shards(regions.across(), regions.down(), shards);
    plan.program = this_program();
    plan.packs = packs;
    if (packs)
        check_grid(*packs, static_cast<std::uint32_t>(tree.tiles_x), static_cast<std::uint32_t>(tree.tiles_y),
                   "the plan");
    return plan;
}

std::vector<ShardPlan::Input> inputs_of(const Recipe& recipe) {
    std::set<std::string> seen;
    std::vector<ShardPlan::Input> inputs;
    for (const std::string& path : files_read(recipe)) {
        std::error_code error;
        const auto bytes = fs::file_size(path, error);
        if (!error && seen.insert(path).second) inputs.push_back({fs::path(path).filename().string(), bytes});
    }
    return inputs;
}

void write_plan(ShardPlan& plan, const Recipe& recipe, const std::string& folder) {
    make_folder(folder);
    const std::string text = plan_text(plan), baked = recipe_text(for_file(recipe, recipe_path(folder)));
    plan.folder = folder;
    plan.id = id_of(text, baked);
    if (fs::exists(plan_path(folder))) {
        if (io::read_text(plan_path(folder)) == text && io::read_text(recipe_path(folder)) == baked) return;
        throw Failure(1, fmt::format("{}: holds another plan; choose another folder, or delete this one", folder));
    }
    for (const auto& entry : fs::directory_iterator(folder))
        if (entry.path().filename() != "recipe.json")
            throw Failure(1, fmt::format("{}: is not empty and has no plan; choose another folder", folder));
    write_text(recipe_path(folder), baked);
    write_text(plan_path(folder), text); // last: with it the plan is there
}

ShardPlan load_plan(const std::string& folder) {
    const std::string path = plan_path(folder);
    if (!fs::exists(path))
        throw Failure(1, fmt::format("{}: has no plan, or is not mounted here; make one with fjell-bake plan IN... "
                                     "-o {} --shards N",
                                     folder, folder));
    const std::string text = io::read_text(path), recipe = io::read_text(recipe_path(folder));
    const json j = io::parse_json(text, path);
    ShardPlan plan;
    try {
        if (j.at("fjell_plan") != plan_version)
            throw Failure(1, fmt::format("{}: is of another version; plan again, into another folder", path));
        plan.folder = folder;
        plan.id = id_of(text, recipe);
        plan.program = j.at("program");
        plan.shards = j.at("shards");
        plan.rounds = j.at("rounds");
        plan.columns = j.at("columns");
        plan.rows = j.at("rows");
        plan.tile_log2 = j.at("tile_log2");
        if (j.contains("packs")) plan.packs = SetGrid{j["packs"].at(0), j["packs"].at(1)};
        for (const json& p : j.at("parts")) plan.parts.push_back({p.at(0), p.at(1), p.at(2), p.at(3)});
        for (const json& i : j.at("inputs")) plan.inputs.push_back({i.at("file"), i.at("bytes")});
    } catch (const json::exception&) {
        throw Failure(1, fmt::format("{}: is damaged; plan again, into another folder", path));
    }
    if (plan.shards < 1 || plan.parts.size() != static_cast<std::size_t>(plan.shards))
        throw Failure(1, fmt::format("{}: is damaged; plan again, into another folder", path));
    return plan;
}

Recipe plan_recipe(const std::string& folder) {
    return load_recipe(recipe_path(folder));
}

void check_program(const ShardPlan& plan) {
    if (plan.program != this_program())
        throw Failure(1, fmt::format("{}: was planned by another build of fjell-bake ({}; this is {}); run the same "
                                     "program on all machines, or plan anew into another folder",
                                     plan.folder, plan.program, this_program()));
}

void check_inputs(const ShardPlan& plan, const Recipe& recipe) {
    const std::vector<ShardPlan::Input> now = inputs_of(recipe);
    if (now == plan.inputs) return;
    std::string changed = "a file";
    for (const ShardPlan::Input& input : plan.inputs)
        if (std::find(now.begin(), now.end(), input) == now.end()) changed = input.path;
    throw Failure(1, fmt::format("{}: {} is not what was planned (gone, or of another size); put it back, or plan anew "
                                 "into another folder",
                                 plan.folder, changed));
}

void check_source(const ShardPlan& plan, const HeightSource& source) {
    if (source.columns != plan.columns || source.rows != plan.rows)
        throw Failure(1,
                      fmt::format("{}: the terrain has {} x {} samples, and {} x {} were planned; put the files back, "
                                  "or plan anew into another folder",
                                  plan.folder, source.columns, source.rows, plan.columns, plan.rows));
}

// ---- what a shard has left

std::string ShardPlan::damage(const ShardStep& step, int shard, const std::string& path) const {
    std::error_code kept; // where this may not write: then only the command helps
    fs::remove(file(step, shard, "json"), kept);
    return fmt::format("{}: is damaged; run {} --again", path, command(step, shard));
}

std::optional<ShardRecord> find_record(const ShardPlan& plan, const ShardStep& step, int shard) {
    const std::string path = plan.file(step, shard, "json");
    if (!fs::exists(path)) return {};
    const json j = json::parse(io::read_text(path), nullptr, false); // of what is no JSON nothing is found
    ShardRecord record;
    try {
        if (from_hex(j.at("plan")) != plan.id)
            throw Failure(1, fmt::format("{}: is of another plan than {}; delete {}/{} and run {}", path,
                                         plan_path(plan.folder), plan.folder, step.name(), plan.command(step, shard)));
        for (const auto& [name, file] : j.at("files").items())
            record.files[name] = {file.at("bytes"),
                                  {from_hex(file.at("digest").at(0)), from_hex(file.at("digest").at(1))}};
        record.seconds = j.at("seconds");
        record.cpu_seconds = j.at("cpu_seconds");
        record.resident_mb = j.at("resident_mb");
        record.seam_bytes_read = j.at("seam_bytes_read");
    } catch (const json::exception&) {
        return {};
    } catch (const Damaged&) {
        return {};
    }
    for (const auto& [name, file] : record.files) {
        std::error_code error;
        const auto bytes = fs::file_size(plan.file(step, shard, name), error);
        if (error || bytes != file.bytes) return {};
    }
    return record;
}

ShardRecord require_record(const ShardPlan& plan, const ShardStep& step, int shard) {
    if (const auto found = find_record(plan, step, shard)) return *found;
    throw Failure(1, fmt::format("{}: shard {}/{} has not completed {}, or its files were cut off; run {}", plan.folder,
                                 shard, plan.shards, step.name(), plan.command(step, shard)));
}

// ---- parcels

namespace {

struct ParcelHead {
    char magic[8];
    std::uint64_t plan, bytes, hash; // of what follows
};
constexpr char parcel_magic[8] = {'F', 'J', 'E', 'L', 'L', 'P', 'C', '1'};

// Takes the head off and returns whose plan it names; nothing where the bytes are not what was written.
std::optional<std::uint64_t> open_parcel(std::vector<std::byte>& bytes) {
    ParcelHead head{};
    if (bytes.size() >= sizeof head) std::memcpy(&head, bytes.data(), sizeof head);
    const std::size_t rest = bytes.size() - std::min(bytes.size(), sizeof head);
    if (std::memcmp(head.magic, parcel_magic, sizeof parcel_magic) != 0 || head.bytes != rest ||
        head.hash != XXH3_64bits(bytes.data() + sizeof head, rest))
        return {};
    bytes.erase(bytes.begin(), bytes.begin() + sizeof head);
    return head.plan;
}

} // namespace

std::vector<std::byte> read_parcel(const ShardPlan& plan, const ShardStep& step, int shard, const std::string& name) {
    const std::string path = plan.file(step, shard, name);
    if (!fs::exists(path)) (void)require_record(plan, step, shard);
    std::vector<std::byte> bytes = io::read_file(path);
    const auto plan_id = open_parcel(bytes);
    if (!plan_id) throw Failure(1, plan.damage(step, shard, path));
    if (*plan_id != plan.id)
        throw Failure(1, fmt::format("{}: is of another plan; run {} --again", path, plan.command(step, shard)));
    return bytes;
}

std::optional<std::vector<std::byte>> find_parcel(const ShardPlan& plan, const std::string& path) {
    if (!fs::exists(path)) return {};
    std::vector<std::byte> bytes = io::read_file(path);
    if (open_parcel(bytes) != plan.id) return {};
    return bytes;
}

void write_parcel(const ShardPlan& plan, const std::string& path, std::span<const std::byte> bytes) {
    ParcelHead head{{}, plan.id, bytes.size(), XXH3_64bits(bytes.data(), bytes.size())};
    std::memcpy(head.magic, parcel_magic, sizeof parcel_magic);
    io::AtomicFile out(path);
    out.write(std::as_bytes(std::span(&head, 1)));
    out.write(bytes);
    out.commit();
}

// ---- scratch

namespace {

// An attempt holds a lock on a file in its folder: one that nobody holds belongs to a dead one. (Where locks do not
// reach other machines, an attempt that still runs there fails with one line, and this one does its work.)
void remove_dead(const std::string& scratch, const std::string& prefix) {
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(scratch, error)) {
        if (!entry.path().filename().string().starts_with(prefix)) continue;
        const std::string lock = (entry.path() / "lock").string();
        const int fd = open(lock.c_str(), O_RDWR | O_CLOEXEC);
        if (fd < 0 || flock(fd, LOCK_EX | LOCK_NB) == 0) fs::remove_all(entry.path(), error);
        if (fd >= 0) close(fd);
    }
}

// While an attempt makes its folder and locks it nobody looks for dead ones: it would look like one. A network's locks
// want a file that is open for writing.
class OneAtATime {
public:
    explicit OneAtATime(const std::string& path) : file_(open(path.c_str(), O_RDWR | O_CLOEXEC)) {
        if (file_ < 0) file_ = open(path.c_str(), O_RDONLY | O_CLOEXEC);
        if (file_ >= 0) (void)flock(file_, LOCK_EX); // not everywhere
    }
    OneAtATime(const OneAtATime&) = delete;
    OneAtATime& operator=(const OneAtATime&) = delete;
    ~OneAtATime() {
        if (file_ >= 0) close(file_);
    }

private:
    int file_;
};

std::string host() {
    char name[256] = {};
    return gethostname(name, sizeof name - 1) == 0 ? name : "host";
}

} // namespace

void remove_dead_attempts(const ShardPlan& plan) {
    const OneAtATime turn(plan.folder + "/plan.json");
    remove_dead(plan.folder + "/scratch", "");
}

ScratchFolder::ScratchFolder(const ShardPlan& plan, const ShardStep& step, int shard)
    : plan_(plan), step_(step), shard_(shard) {
    const std::string scratch = plan.folder + "/scratch", prefix = fmt::format("{}-{}.", step.name(), shard);
    make_folder(scratch);
    make_folder(fmt::format("{}/{}", plan.folder, step.name()));
    const OneAtATime turn(plan.folder + "/plan.json");
    remove_dead(scratch, prefix);
    path_ = fmt::format("{}/{}{}.{}", scratch, prefix, host(), getpid());
    make_folder(path_);
    lock_ = open(file("lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (lock_ < 0) io::disk_failure(path_, "open the lock in");
    (void)flock(lock_, LOCK_EX | LOCK_NB); // not everywhere; then nobody takes it for dead but us
}

ScratchFolder::~ScratchFolder() {
    std::error_code error;
    fs::remove_all(path_, error);
    close(lock_);
}

void ScratchFolder::write_parcel(const std::string& name, std::span<const std::byte> bytes) {
    baker::write_parcel(plan_, file(name), bytes);
    add(name);
}

void ScratchFolder::add(const std::string& name, const Digest& digest) {
    std::error_code error;
    files_[name] = {fs::file_size(file(name), error), digest};
    if (error)
        throw Failure(3, fmt::format("{}: is gone; the shared folder went away, or another attempt removed it; run "
                                     "the step again",
                                     file(name)));
}

void ScratchFolder::publish(ShardRecord record) {
    ordered_json j{{"plan", hex(plan_.id)}, {"files", ordered_json::object()}};
    for (const auto& [name, f] : files_) {
        j["files"][name] = {{"bytes", f.bytes}, {"digest", {hex(f.digest.forwards), hex(f.digest.backwards)}}};
        const std::string to = plan_.file(step_, shard_, name);
        if (rename(file(name).c_str(), to.c_str()) != 0) io::disk_failure(to, "rename");
    }
    j["seconds"] = record.seconds;
    j["cpu_seconds"] = record.cpu_seconds;
    j["resident_mb"] = record.resident_mb;
    j["seam_bytes_read"] = record.seam_bytes_read;
    write_text(plan_.file(step_, shard_, "json"), j.dump(1) + "\n");
}

} // namespace fjell::baker
