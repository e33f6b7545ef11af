// A bake to be killed, starved and interrupted: bake_child OUT HEIGHTS COLUMNS ROWS THREADS [IMAGE]. Heights are floats
// as they lie in memory, NaN where there is a hole; read in small windows and kept in files, so that wherever it ends
// there are complete stages to go on from.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <span>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "baker/bake/bake.h"
#include "baker/read/windows.h"
#include "fjell/io/failure.h"
#include "io/file.h"

namespace {

using namespace fjell;
using namespace fjell::baker;

class FileReader final : public HeightReader {
public:
    FileReader(const std::string& path, std::int32_t columns) : path_(path), columns_(columns) {
        fd_ = open(path.c_str(), O_RDONLY | O_CLOEXEC);
        if (fd_ < 0) throw Failure(1, path + ": no such file; put it back");
    }
    ~FileReader() override { close(fd_); }
    void read(const Window& window, float* to, ReadStatistics& statistics) override {
        const std::span<float> heights(to, window.area());
        try {
            io::read_all(fd_,
                         static_cast<std::uint64_t>(window.y) * static_cast<std::uint64_t>(columns_) * sizeof(float),
                         std::as_writable_bytes(heights), path_);
        } catch (const Failure&) {
            throw Failure(1, path_ + ": cannot be read; mend it");
        }
        statistics.per_unit = 1;
        for (std::size_t i = 0; i < heights.size(); ++i) {
            const float h = heights[i];
            if (std::isnan(h)) {
                statistics.voids.add(static_cast<std::int32_t>(i) % columns_,
                                     window.y + static_cast<std::int32_t>(i) / columns_);
                continue;
            }
            statistics.least_m = std::min(statistics.least_m, h);
            statistics.most_m = std::max(statistics.most_m, h);
        }
    }

private:
    std::string path_;
    std::int32_t columns_;
    int fd_ = -1;
};

class FileSource final : public HeightSource {
public:
    FileSource(std::string path, int the_columns, int the_rows) : path_(std::move(path)) {
        columns = the_columns;
        rows = the_rows;
        spacing_m[0] = spacing_m[1] = 30;
    }
    [[nodiscard]] std::unique_ptr<HeightReader> reader() const override {
        return std::make_unique<FileReader>(path_, columns);
    }
    [[nodiscard]] std::vector<Window> windows(std::size_t) const override { // whole rows, as few as make many windows
        return cut_along({0, 0, columns, rows}, {columns, 1, 0, 0}, static_cast<std::size_t>(columns) * 8);
    }
    [[nodiscard]] SourceProperties properties(const ReadStatistics& statistics) const override {
        return {0.1, static_cast<double>(statistics.least_m), statistics.voids.count > 0};
    }
    [[nodiscard]] std::string identity() const override { return path_; }

private:
    std::string path_;
};

int bake_once(int argc, char** argv) {
    if (argc != 6 && argc != 7) throw Failure(2, "OUT HEIGHTS COLUMNS ROWS THREADS [IMAGE]");
    io::catch_interrupts();
    BakeOptions options;
    options.tile_log2 = 6;
    options.region_cells = 64;
    options.threads = std::atoi(argv[5]);
    options.compression = 1;
    options.max_texture_log2 = 6;
    options.horizon_spacing = 4;
    options.layers_path = FJELL_SOURCE_DIR "/content/materials/splat/alpine.json";
    options.splat_spacing = 1;
    options.checkpoint_s = 0;
    if (argc == 7) options.texture_paths = {argv[6]};
    options.progress = [](const char*, std::uint64_t, std::uint64_t) { io::check_interrupt(); };
    const BakeSummary s = bake(FileSource(argv[2], std::atoi(argv[3]), std::atoi(argv[4])), options, argv[1]);
    std::puts(s.resumed ? "resumed" : "new");
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return fjell::io::run_tool("bake_child", [&] { return bake_once(argc, argv); });
}
