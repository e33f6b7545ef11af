// The folder that shards share, and nothing else do they: a plan, and for each step what each shard has left there.
//
//   plan.json, recipe.json     what is baked and how it is cut
//   STEP/K.json                shard K (1 to N) has completed this step: sizes and digests of its files, seconds
//   STEP/K.NAME                its files: stores, chunks, and parcels, which are small and carry a checksum
//   scratch/                   what steps at work write; a step that dies leaves some, which the next one removes
//
// Files are written in scratch and renamed into their place, K.json last. So what is there is complete, whoever died,
// and a shard that runs twice, even at the same time, writes the same bytes to the same names. Times of files decide
// nothing: clocks may differ. All throw Failure: 1 with the command to run for what is missing, damaged or of another
// plan, 3 for the disk.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "baker/bake/context.h"
#include "baker/bake/recipe.h"
#include "baker/pack/write_set.h"
#include "baker/shard/shard_plan.h"
#include "baker/store/store.h"

namespace fjell::baker {

// What plan.json says.
struct ShardPlan {
    std::string folder;
    std::uint64_t id = 0; // of plan.json and recipe.json, to the byte; every file of a shard carries it
    int shards = 1, rounds = 1;
    std::int32_t columns = 0, rows = 0;
    int tile_log2 = 0;
    std::vector<Window> parts; // of regions; no area: nothing to do
    std::string program;       // of the build that has planned
    // Of a plan for a set: its packs. Then regions that it has no use for are not baked (shard_ground.h).
    std::optional<SetGrid> packs;
    struct Input {
        std::string path; // as the recipe's
        std::uint64_t bytes = 0;
        friend bool operator==(const Input&, const Input&) = default;
    };
    std::vector<Input> inputs;

    // K counts from 1, as scripts do.
    [[nodiscard]] std::string file(const ShardStep& step, int shard, const std::string& name) const {
        return fmt::format("{}/{}/{}.{}", folder, step.name(), shard, name);
    }
    // The command that makes a shard's files again, for messages.
    [[nodiscard]] std::string command(const ShardStep& step, int shard) const {
        return fmt::format("fjell-bake shard {} {}/{} --step {}", folder, shard, shards, step.name());
    }
    // What to say of a file of that step that is damaged. The step counts as not complete from now on, so that a launch
    // runs it again.
    [[nodiscard]] std::string damage(const ShardStep& step, int shard, const std::string& path) const;
    [[nodiscard]] bool empty(int shard) const { return parts[static_cast<std::size_t>(shard) - 1].area() == 0; }
};

// The regions of shards are those of a bake with default options.
[[nodiscard]] ShardPlan make_shard_plan(const HeightSource& source, const BakeOptions& options, int shards,
                                        const std::optional<SetGrid>& packs = {});
// Files of a recipe with their sizes.
[[nodiscard]] std::vector<ShardPlan::Input> inputs_of(const Recipe& recipe);
// Into a folder that is new, empty, or has the same plan already: then nothing changes. Sets folder and id.
void write_plan(ShardPlan& plan, const Recipe& recipe, const std::string& folder);
[[nodiscard]] ShardPlan load_plan(const std::string& folder);
[[nodiscard]] Recipe plan_recipe(const std::string& folder);
// Throws when this program, the terrain or the files are not those that were planned.
void check_program(const ShardPlan& plan);
void check_inputs(const ShardPlan& plan, const Recipe& recipe);
void check_source(const ShardPlan& plan, const HeightSource& source);

// ---- what a shard has left

struct ShardRecord {
    struct File {
        std::uint64_t bytes = 0;
        Digest digest; // of stores; zero: it carries a checksum of its own
    };
    std::map<std::string, File> files;
    double seconds = 0, cpu_seconds = 0, resident_mb = 0;
    std::uint64_t seam_bytes_read = 0; // of other shards' files
};
// Nothing where the step is not complete: no record or a damaged one, or files that are missing or of another size.
[[nodiscard]] std::optional<ShardRecord> find_record(const ShardPlan& plan, const ShardStep& step, int shard);
// The same, but throws Failure 1 with the command to run.
[[nodiscard]] ShardRecord require_record(const ShardPlan& plan, const ShardStep& step, int shard);

// ---- parcels: small files with a checksum

[[nodiscard]] std::vector<std::byte> read_parcel(const ShardPlan& plan, const ShardStep& step, int shard,
                                                 const std::string& name);

// One that is nobody's: the same whoever writes it, and made again where it is missing, damaged or of another plan.
[[nodiscard]] std::optional<std::vector<std::byte>> find_parcel(const ShardPlan& plan, const std::string& path);
void write_parcel(const ShardPlan& plan, const std::string& path, std::span<const std::byte> bytes);

// Where a shard at work writes one step's files, and from where they are renamed when it is complete.
class ScratchFolder {
public:
    // Removes what dead attempts at the same have left, as far as this machine knows them for dead.
    ScratchFolder(const ShardPlan& plan, const ShardStep& step, int shard);
    ~ScratchFolder();
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;

    [[nodiscard]] std::string file(const std::string& name) const { return path_ + "/" + name; }
    void write_parcel(const std::string& name, std::span<const std::byte> bytes);
    // A file that lies there, closed or not; digest: of a store.
    void add(const std::string& name, const Digest& digest = {});
    // Renames all that was added, then writes the record.
    void publish(ShardRecord record);

private:
    const ShardPlan& plan_;
    ShardStep step_;
    int shard_, lock_ = -1;
    std::string path_;
    std::map<std::string, ShardRecord::File> files_;
};

// Removes what attempts have left that were killed when their step was complete: nobody does that step again. What
// cannot be removed stays.
void remove_dead_attempts(const ShardPlan& plan);

// ---- bytes of parcels: values one behind the other

class ParcelWriter {
public:
    template <typename T>
    void put(const T& value) {
        static_assert(std::is_trivially_copyable_v<T>);
        put_all(std::span(&value, 1));
    }
    template <typename T>
    void put_all(std::span<const T> values) {
        const auto from = std::as_bytes(values);
        bytes.insert(bytes.end(), from.begin(), from.end());
    }
    std::vector<std::byte> bytes;
};

class ParcelReader {
public:
    explicit ParcelReader(std::span<const std::byte> bytes) : bytes_(bytes) {}
    template <typename T>
    void get_all(std::span<T> to) {
        const auto out = std::as_writable_bytes(to);
        if (out.size() > bytes_.size() - at_) throw std::logic_error("a parcel is shorter than what is read from it");
        std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(at_), out.size(), out.begin());
        at_ += out.size();
    }
    template <typename T>
    [[nodiscard]] T get() {
        T value;
        get_all(std::span(&value, 1));
        return value;
    }
    template <typename T>
    void skip(std::size_t values) {
        if (values > (bytes_.size() - at_) / sizeof(T))
            throw std::logic_error("a parcel is shorter than what is skipped in it");
        at_ += values * sizeof(T);
    }
    [[nodiscard]] bool ended() const { return at_ == bytes_.size(); }

private:
    std::span<const std::byte> bytes_;
    std::size_t at_ = 0;
};

} // namespace fjell::baker
