#include "baker/read/edited_source.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
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
        : scale_(scale), path_(path), reader_(source.reader()), grid_(source.columns, source.rows, source.spacing_m) {}

    void apply(const Stamp& stamp) {
        if (paints(stamp.shape)) return paint(stamp);
        const Rect all = edit::samples_of(grid_, stamp);
        // All blocks are evaluated on the ground as it was before any of them changes.
        std::vector<std::pair<std::vector<float>*, std::vector<float>>> changed;
        for (std::int32_t by = all.y0 / block_side; !all.empty() && by <= all.y1 / block_side; ++by)
            for (std::int32_t bx = all.x0 / block_side; bx <= all.x1 / block_side; ++bx) {
                const Rect block = samples_of_block(bx, by), piece = all.within(block);
                if (!edit::may_change(grid_, stamp, piece)) continue;
                std::vector<float>& before = block_at(bx, by);
                std::vector<float> after = before;
                for (std::int32_t y = piece.y0; y <= piece.y1; ++y)
                    for (std::int32_t x = piece.x0; x <= piece.x1; ++x) {
                        float& height_m = after[index_in_block(x, y)];
                        if (!std::isnan(height_m)) height_m = stamped(stamp, {x, y}, height_m);
                    }
                if (after != before) changed.emplace_back(&before, std::move(after));
            }
        for (auto& [before, after] : changed) *before = std::move(after);
    }

    [[nodiscard]] const edit::PaintSource* paint() const { return painted_.empty() ? nullptr : &paint_; }

    // Of a window that was read from the source: puts in what stamps have made of it.
    void put(const Window& window, float* heights_m, ReadStatistics& statistics) const {
        const Rect wanted{window.x, window.y, window.x + window.columns - 1, window.y + window.rows - 1};
        for (std::int32_t by = wanted.y0 / block_side; by <= wanted.y1 / block_side; ++by)
            for (std::int32_t bx = wanted.x0 / block_side; bx <= wanted.x1 / block_side; ++bx) {
                const auto found = blocks_.find(key(bx, by));
                if (found == blocks_.end()) continue;
                const Rect part = samples_of_block(bx, by).within(wanted);
                for (std::int32_t y = part.y0; y <= part.y1; ++y)
                    for (std::int32_t x = part.x0; x <= part.x1; ++x) {
                        const float height_m = found->second[index_in_block(x, y)];
                        if (std::isnan(height_m)) continue;
                        heights_m[static_cast<std::ptrdiff_t>(y - window.y) * window.columns + (x - window.x)] =
                            height_m;
                        statistics.least_m = std::min(statistics.least_m, height_m);
                        statistics.most_m = std::max(statistics.most_m, height_m);
                    }
            }
    }

private:
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
    std::vector<float> read_block(const Rect& block) {
        std::vector<float> read(static_cast<std::size_t>(block.columns()) * static_cast<std::size_t>(block.rows()));
        ReadStatistics ignored; // the samples are counted when they are baked
        reader_->read({block.x0, block.y0, block.columns(), block.rows()}, read.data(), ignored);
        std::vector<float> heights(std::size_t{block_side} * block_side, std::numeric_limits<float>::quiet_NaN());
        for (std::int32_t y = 0; y < block.rows(); ++y)
            std::copy_n(read.data() + static_cast<std::ptrdiff_t>(y) * block.columns(), block.columns(),
                        heights.data() + static_cast<std::ptrdiff_t>(y) * block_side);
        return heights;
    }
    std::vector<float>& block_at(std::int32_t bx, std::int32_t by) {
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
    [[nodiscard]] float height_at(std::int32_t x, std::int32_t y) {
        return block_at(x / block_side, y / block_side)[index_in_block(x, y)];
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
    [[nodiscard]] float stamped(const Stamp& stamp, SampleIndex at, float now_m) {
        edit::Surroundings around{height_of(now_m), 0, 0};
        float pack_m = now_m;
        if (stamp.shape == StampShape::restore) {
            ReadStatistics ignored;
            reader_->read({at.column, at.row, 1, 1}, &pack_m, ignored);
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
    std::unique_ptr<HeightReader> reader_;
    edit::StampGrid grid_;
    std::unordered_map<std::uint64_t, std::vector<float>> blocks_; // whose references stay when others come
    std::unordered_map<std::uint64_t, std::unique_ptr<edit::PaintBlock>> painted_;
    edit::PaintSource paint_{this, find_painted};
};

class EditedReader final : public HeightReader {
public:
    EditedReader(std::unique_ptr<HeightReader> reader, std::shared_ptr<const Overlay> overlay)
        : reader_(std::move(reader)), overlay_(std::move(overlay)) {}
    void read(const Window& window, float* to, ReadStatistics& statistics) override {
        reader_->read(window, to, statistics);
        overlay_->put(window, to, statistics);
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
        columns = source_->columns, rows = source_->rows;
        std::copy_n(source_->spacing_m, 2, spacing_m);
        std::copy_n(source_->crs_origin, 2, crs_origin);
        std::copy_n(source_->crs_step, 2, crs_step);
        crs_wkt = source_->crs_wkt;
        facts = source_->facts;
        if (const auto* const pack = dynamic_cast<const PackSource*>(source_.get())) scale_ = pack->height_scale();
        const std::string text = io::write_stamps(stamps);
        hash_ = XXH3_64bits(text.data(), text.size());
        const auto overlay = std::make_shared<Overlay>(*source_, scale_, name);
        for (const io::TimedStamp& stamp : stamps) overlay->apply(stamp.what.stamp());
        overlay_ = overlay;
    }

    [[nodiscard]] std::unique_ptr<HeightReader> reader() const override {
        return std::make_unique<EditedReader>(source_->reader(), overlay_);
    }
    [[nodiscard]] int readers(int threads) const override { return source_->readers(threads); }
    [[nodiscard]] std::vector<Window> windows(std::size_t most) const override { return source_->windows(most); }
    [[nodiscard]] SourceProperties properties(const ReadStatistics& statistics) const override {
        SourceProperties all = source_->properties(statistics);
        if (!scale_) all.native_quantum_m = 0; // stamps know no step
        return all;
    }
    [[nodiscard]] const edit::PaintSource* paint() const override { return overlay_->paint(); }
    [[nodiscard]] std::string identity() const override {
        return fmt::format("{}\nedits {:016x}", source_->identity(), hash_);
    }

private:
    std::unique_ptr<HeightSource> source_;
    std::optional<HeightScale> scale_; // a pack's
    std::shared_ptr<const Overlay> overlay_;
    std::uint64_t hash_ = 0; // of the stamps
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
