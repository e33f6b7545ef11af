#include "baker/read/edited_source.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <xxhash.h>

#include "baker/read/pack_source.h"
#include "shared/paint.h"
#include "shared/stamp.h"

namespace fjell::baker {

namespace {

using edit::paints;
using edit::Rect;

constexpr std::int32_t block_side = 64;

// The samples of blocks that stamps have touched.
class Overlay {
public:
    Overlay(const HeightSource& source, const std::optional<HeightScale>& scale, const std::string& path)
        : scale_(scale), path_(path), reader_(source.reader()), grid_(source.columns, source.rows, source.spacing_m) {
        if (const auto* const pack = dynamic_cast<const PackSource*>(&source)) ground_reader_ = pack->ground_reader();
        fills_ = ground_reader_ != nullptr;
    }

    void apply(const Stamp& stamp) {
        if (paints(stamp.shape)) return paint(stamp);
        if (!edit::moves_ground(stamp.shape)) return;
        const Rect all = edit::samples_of(grid_, stamp);
        // All blocks are evaluated on the ground as it was before any of them changes.
        std::vector<std::pair<Block*, Block>> changed;
        for (std::int32_t by = all.y0 / block_side; !all.empty() && by <= all.y1 / block_side; ++by)
            for (std::int32_t bx = all.x0 / block_side; bx <= all.x1 / block_side; ++bx) {
                const Rect block = samples_of_block(bx, by), piece = all.within(block);
                if (!edit::may_change(grid_, stamp, piece)) continue;
                Block& before = block_at(bx, by);
                Block after = before;
                for (std::int32_t y = piece.y0; y <= piece.y1; ++y)
                    for (std::int32_t x = piece.x0; x <= piece.x1; ++x) stamp_sample(stamp, {x, y}, after);
                changed.emplace_back(&before, std::move(after));
            }
        for (auto& [before, after] : changed) {
            after.note_changes(*before);
            *before = std::move(after);
        }
    }

    // Samples, block by block.
    [[nodiscard]] std::vector<Window> changed_heights() const {
        std::vector<Window> all;
        for (const auto& [place, block] : blocks_) {
            const auto bx = static_cast<std::int32_t>(place & 0xffff'ffff), by = static_cast<std::int32_t>(place >> 32);
            const Rect& r = block.changed;
            if (!r.empty()) all.push_back({bx * block_side + r.x0, by * block_side + r.y0, r.columns(), r.rows()});
        }
        return all;
    }
    [[nodiscard]] std::vector<Window> painted() const {
        std::vector<Window> all;
        constexpr std::int32_t side = edit::paint_side;
        for (const auto& [place, block] : painted_) all.push_back({block->x * side, block->y * side, side, side});
        return all;
    }

    [[nodiscard]] const edit::PaintSource* paint() const { return painted_.empty() ? nullptr : &paint_; }

    // Of a window that was read from the source, and nothing else: puts in what stamps have made of it.
    void put(const Window& window, float* heights_m, ReadStatistics& statistics) const {
        const Rect wanted{window.x, window.y, window.x + window.columns - 1, window.y + window.rows - 1};
        for (std::int32_t by = wanted.y0 / block_side; by <= wanted.y1 / block_side; ++by)
            for (std::int32_t bx = wanted.x0 / block_side; bx <= wanted.x1 / block_side; ++bx) {
                const auto found = blocks_.find(key(bx, by));
                if (found == blocks_.end()) continue;
                const Rect part = samples_of_block(bx, by).within(wanted);
                for (std::int32_t y = part.y0; y <= part.y1; ++y)
                    for (std::int32_t x = part.x0; x <= part.x1; ++x) {
                        const Block& block = found->second;
                        const float height_m = block.heights_m[index_in_block(x, y)];
                        float& to =
                            heights_m[static_cast<std::ptrdiff_t>(y - window.y) * window.columns + (x - window.x)];
                        if (block.holes[index_in_block(x, y)] != 0) {
                            if (!std::isnan(to) && !fills_) statistics.voids.add(x, y);
                            to = std::numeric_limits<float>::quiet_NaN();
                            continue;
                        }
                        to = height_m;
                        statistics.least_m = std::min(statistics.least_m, height_m);
                        statistics.most_m = std::max(statistics.most_m, height_m);
                    }
            }
        if (!fills_) return;
        statistics.voids = {};
        for (std::int32_t y = wanted.y0; y <= wanted.y1; ++y)
            for (std::int32_t x = wanted.x0; x <= wanted.x1; ++x)
                if (std::isnan(heights_m[static_cast<std::ptrdiff_t>(y - window.y) * window.columns + (x - window.x)]))
                    statistics.voids.add(x, y);
    }

    // Samples that are holes, and would not be without stamps.
    [[nodiscard]] std::uint64_t cut() const {
        std::uint64_t count = 0;
        for (const auto& [place, block] : blocks_)
            for (std::size_t i = 0; i < block.holes.size(); ++i)
                count += block.holes[i] != 0 && block.were_holes[i] == 0;
        return count;
    }

private:
    // Heights, those under holes too: NaN where nothing is known of any. Which samples are holes, and were.
    struct Block {
        std::vector<float> heights_m;
        std::vector<std::uint8_t> holes, were_holes;
        Rect changed; // of the block, within which all lie that any stamp has changed

        void note_changes(const Block& before) {
            for (std::size_t i = 0; i < heights_m.size(); ++i) {
                if (holes[i] == before.holes[i] && std::memcmp(&heights_m[i], &before.heights_m[i], sizeof(float)) == 0)
                    continue;
                const auto x = static_cast<std::int32_t>(i % block_side), y = static_cast<std::int32_t>(i / block_side);
                changed = changed.with({x, y, x, y});
            }
        }
    };

    static std::uint64_t key(std::int32_t bx, std::int32_t by) {
        return static_cast<std::uint64_t>(static_cast<std::uint32_t>(by)) << 32 | static_cast<std::uint32_t>(bx);
    }
    [[nodiscard]] Rect samples_of_block(std::int32_t bx, std::int32_t by) const {
        return Rect{bx * block_side, by * block_side, (bx + 1) * block_side - 1, (by + 1) * block_side - 1}.within(
            {0, 0, grid_.columns - 1, grid_.rows - 1});
    }
    static std::size_t index_in_block(std::int32_t x, std::int32_t y) {
        return static_cast<std::size_t>(y % block_side) * block_side + static_cast<std::size_t>(x % block_side);
    }
    Block read_block(const Rect& block) {
        std::vector<float> read(static_cast<std::size_t>(block.columns()) * static_cast<std::size_t>(block.rows()));
        ReadStatistics ignored; // the samples are counted when they are baked
        reader_->read({block.x0, block.y0, block.columns(), block.rows()}, read.data(), ignored);
        constexpr std::size_t area = std::size_t{block_side} * block_side;
        Block made{
            std::vector<float>(area, std::numeric_limits<float>::quiet_NaN()), std::vector<std::uint8_t>(area), {}, {}};
        const auto rows = [&](const auto& put) {
            for (std::int32_t y = 0; y < block.rows(); ++y)
                for (std::int32_t x = 0; x < block.columns(); ++x)
                    put(static_cast<std::size_t>(y) * block_side + static_cast<std::size_t>(x),
                        read[static_cast<std::size_t>(y) * static_cast<std::size_t>(block.columns()) +
                             static_cast<std::size_t>(x)]);
        };
        rows([&](std::size_t to, float height_m) {
            made.heights_m[to] = height_m;
            made.holes[to] = std::isnan(height_m);
        });
        made.were_holes = made.holes;
        if (ground_reader_ != nullptr) {
            ground_reader_->read({block.x0, block.y0, block.columns(), block.rows()}, read.data(), ignored);
            rows([&](std::size_t to, float height_m) { made.heights_m[to] = height_m; });
        }
        return made;
    }
    Block& block_at(std::int32_t bx, std::int32_t by) {
        const auto found = blocks_.find(key(bx, by));
        if (found != blocks_.end()) return found->second;
        if ((blocks_.size() + 1) * block_side * block_side > most_edited_samples)
            throw Failure(1, fmt::format("{}: changes more than {} million samples; bake it in parts", path_,
                                         most_edited_samples >> 20));
        return blocks_.emplace(key(bx, by), read_block(samples_of_block(bx, by))).first->second;
    }

    // As the runtime does (edit/paint.cpp).
    void paint(const Stamp& stamp) {
        const Rect all = edit::samples_of(grid_, stamp);
        for (std::int32_t by = all.y0 >> edit::paint_log2; !all.empty() && by <= all.y1 >> edit::paint_log2; ++by)
            for (std::int32_t bx = all.x0 >> edit::paint_log2; bx <= all.x1 >> edit::paint_log2; ++bx) {
                const std::int32_t x = bx * edit::paint_side, y = by * edit::paint_side;
                if (!edit::may_change(grid_, stamp, {x, y, x + edit::paint_side - 1, y + edit::paint_side - 1}))
                    continue;
                if (stamp.shape == StampShape::unpaint && !painted_.contains(key(bx, by))) continue;
                if ((painted_.size() + 1) * edit::paint_side * edit::paint_side > most_edited_samples)
                    throw Failure(1, fmt::format("{}: paints more than {} million samples; bake it in parts", path_,
                                                 most_edited_samples >> 20));
                std::unique_ptr<edit::PaintBlock>& block = painted_[key(bx, by)];
                if (!block) {
                    block = std::make_unique<edit::PaintBlock>();
                    block->x = bx, block->y = by;
                }
                (void)edit::paint_block(grid_, stamp, *block);
            }
    }
    static const edit::PaintBlock* find_painted(const void* overlay, std::int32_t x, std::int32_t y) {
        const auto& painted = static_cast<const Overlay*>(overlay)->painted_;
        const auto found = painted.find(key(x, y));
        return found == painted.end() ? nullptr : found->second.get();
    }

    [[nodiscard]] double rounded(double height_m) const {
        if (!scale_) return height_m;
        const double base = scale_->base_m, step = scale_->quantum_m;
        return scale_->height_m(static_cast<std::int32_t>(std::floor((height_m - base) / step + 0.5)));
    }
    // As the runtime has it, a whole number of steps from the base, in double.
    [[nodiscard]] double height_of(float height_m) const {
        if (!scale_) return height_m;
        const double base = scale_->base_m, step = scale_->quantum_m;
        return base + std::floor((static_cast<double>(height_m) - base) / step + 0.5) * step;
    }
    // NaN: a hole.
    [[nodiscard]] float height_at(std::int32_t x, std::int32_t y) {
        const Block& block = block_at(x / block_side, y / block_side);
        const std::size_t at = index_in_block(x, y);
        return block.holes[at] != 0 ? std::numeric_limits<float>::quiet_NaN() : block.heights_m[at];
    }
    [[nodiscard]] double mean_around(SampleIndex at) {
        const Rect near = Rect{at.column - 1, at.row - 1, at.column + 1, at.row + 1}.within(
            {0, 0, grid_.columns - 1, grid_.rows - 1});
        double sum = 0;
        int count = 0;
        for (std::int32_t y = near.y0; y <= near.y1; ++y)
            for (std::int32_t x = near.x0; x <= near.x1; ++x)
                if (const float h = height_at(x, y); !std::isnan(h)) sum += height_of(h), ++count;
        return sum / count;
    }
    void stamp_sample(const Stamp& stamp, SampleIndex at, Block& after) {
        const std::size_t i = index_in_block(at.column, at.row);
        float& height_m = after.heights_m[i];
        std::uint8_t& hole = after.holes[i];
        const bool restores = stamp.shape == StampShape::restore;
        if (hole != 0 && !restores && !edit::makes_or_fills_holes(stamp.shape)) return;
        switch (edit::hole_change(grid_, stamp, at)) {
        case edit::HoleChange::none: break;
        case edit::HoleChange::cut: hole = 1; break;
        case edit::HoleChange::as_in_pack: hole = after.were_holes[i]; break;
        case edit::HoleChange::fill:
            if (std::isnan(height_m))
                throw Failure(1, fmt::format("{}: fills a void at column {}, row {}, where no file has a height; bake "
                                             "the heights first, and give the pack with the stamps",
                                             path_, at.column, at.row));
            hole = 0;
            break;
        }
        if (!std::isnan(height_m)) height_m = stamped(stamp, at, height_m);
    }
    [[nodiscard]] float stamped(const Stamp& stamp, SampleIndex at, float now_m) {
        edit::Surroundings around{height_of(now_m), 0, 0};
        float pack_m = now_m;
        if (stamp.shape == StampShape::restore) {
            ReadStatistics ignored;
            (ground_reader_ != nullptr ? ground_reader_ : reader_)->read({at.column, at.row, 1, 1}, &pack_m, ignored);
            around.pack_m = height_of(pack_m);
        }
        if (stamp.shape == StampShape::smooth) around.mean_m = mean_around(at);
        const double new_m = edit::stamped_m(grid_, stamp, at, around);
        if (std::isnan(new_m)) return now_m;
        if (stamp.shape == StampShape::restore && new_m == around.pack_m) return pack_m;
        return static_cast<float>(rounded(new_m));
    }

    std::optional<HeightScale> scale_;
    std::string path_;
    std::unique_ptr<HeightReader> reader_, ground_reader_; // the latter of a pack
    bool fills_ = false; // stamps may fill voids of the source; it has no implausible heights then
    edit::StampGrid grid_;
    std::unordered_map<std::uint64_t, Block> blocks_; // whose references stay when others come
    std::unordered_map<std::uint64_t, std::unique_ptr<edit::PaintBlock>> painted_;
    edit::PaintSource paint_{this, find_painted};
};

class EditedReader final : public HeightReader {
public:
    EditedReader(std::unique_ptr<HeightReader> reader, std::shared_ptr<const Overlay> overlay)
        : reader_(std::move(reader)), overlay_(std::move(overlay)) {}
    void read(const Window& window, float* to, ReadStatistics& statistics) override {
        ReadStatistics own;
        reader_->read(window, to, own);
        overlay_->put(window, to, own);
        statistics.add(own);
    }
    [[nodiscard]] bool covers(const Window& window) override { return reader_->covers(window); }

private:
    std::unique_ptr<HeightReader> reader_;
    std::shared_ptr<const Overlay> overlay_;
};

class EditedSource final : public HeightSource {
public:
    EditedSource(std::unique_ptr<HeightSource> source, const std::vector<io::TimedStamp>& stamps,
                 const std::string& name)
        : source_(std::move(source)) {
        take_place_of(*source_);
        if (const auto* const pack = dynamic_cast<const PackSource*>(source_.get())) scale_ = pack->height_scale();
        const std::string text = io::write_stamps(stamps);
        hash_ = XXH3_64bits(text.data(), text.size());
        const auto overlay = std::make_shared<Overlay>(*source_, scale_, name);
        for (const io::TimedStamp& stamp : stamps) {
            overlay->apply(stamp.what.stamp());
            if (edit::locks(stamp.what.plain.shape)) kept_.push_back(stamp.what);
            moves_ = moves_ || edit::moves_ground(stamp.what.plain.shape);
        }
        for (const io::KeptStamp& stamp : kept_) locks_.push_back(stamp.stamp());
        cut_ = overlay->cut();
        if (scale_) {
            changes_.pack = dynamic_cast<const PackSource*>(source_.get());
            changes_.heights = overlay->changed_heights();
            changes_.paint = overlay->painted();
        }
        name_ = name;
        overlay_ = overlay;
    }

    [[nodiscard]] std::unique_ptr<HeightReader> reader() const override {
        return std::make_unique<EditedReader>(source_->reader(), overlay_);
    }
    [[nodiscard]] int readers(int threads) const override { return source_->readers(threads); }
    [[nodiscard]] std::vector<Window> windows(std::size_t most) const override { return source_->windows(most); }
    [[nodiscard]] SourceProperties properties(const ReadStatistics& statistics) const override {
        ReadStatistics own = statistics; // without what stamps cut out
        own.voids.count -= std::min(own.voids.count, cut_);
        SourceProperties all = source_->properties(own);
        if (cut_ != 0 && own.voids.count + own.implausible.count > 0 && !all.holes)
            throw Failure(2, fmt::format("{} cuts holes, and --nodata fill leaves none; take one of them", name_));
        all.holes = all.holes || cut_ != 0;
        if (!scale_ && moves_) all.native_quantum_m = 0; // stamps know no step
        return all;
    }
    [[nodiscard]] const edit::PaintSource* paint() const override { return overlay_->paint(); }
    [[nodiscard]] const PackChanges* changes() const override { return scale_ ? &changes_ : nullptr; }
    [[nodiscard]] std::span<const Stamp> locks() const override { return locks_; }
    [[nodiscard]] std::string identity() const override {
        return fmt::format("{}\nedits {:016x}", source_->identity(), hash_);
    }

private:
    std::unique_ptr<HeightSource> source_;
    std::optional<HeightScale> scale_; // a pack's
    PackChanges changes_;              // of one
    std::shared_ptr<const Overlay> overlay_;
    bool moves_ = false;              // some of the ground
    std::vector<io::KeptStamp> kept_; // that locks_ points into
    std::vector<Stamp> locks_;
    std::uint64_t hash_ = 0; // of the stamps
    std::uint64_t cut_ = 0;  // samples
    std::string name_;
};

} // namespace

std::unique_ptr<HeightSource> edited_source(std::unique_ptr<HeightSource> source, const std::string& path) {
    const auto* const pack = dynamic_cast<const PackSource*>(source.get());
    // A journal's places are its pack's: of other heights they would be somewhere else.
    if (pack == nullptr && io::is_journal(path))
        throw Failure(1, fmt::format("{}: is a journal, which belongs to a pack; give that as the input", path));
    std::vector<io::TimedStamp> stamps = io::read_stamps(path, pack != nullptr ? &pack->header() : nullptr);
    return edited_source(std::move(source), stamps, path);
}

std::unique_ptr<HeightSource> edited_source(std::unique_ptr<HeightSource> source,
                                            const std::vector<io::TimedStamp>& stamps, const std::string& name) {
    return std::make_unique<EditedSource>(std::move(source), stamps, name);
}

} // namespace fjell::baker
