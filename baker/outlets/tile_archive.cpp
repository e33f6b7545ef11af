#include "baker/outlets/tile_archive.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <span>

#include <fmt/format.h>
#include <sqlite3.h>
#include <xxhash.h>

#include "baker/bake/bake.h"
#include "baker/outlets/quantized_mesh.h"
#include "io/file.h"
#include "io/stop_flag.h"

namespace fjell::baker {

namespace {

std::vector<std::byte> as_bytes(const std::string& text) {
    const auto bytes = std::as_bytes(std::span(text));
    return {bytes.begin(), bytes.end()};
}

// ---- MBTiles 1.3: rows from the south

class Database {
public:
    explicit Database(const std::string& path) : path_(path) {
        check(sqlite3_open(path.c_str(), &db_));
        run("PRAGMA journal_mode=OFF; PRAGMA synchronous=NORMAL; PRAGMA page_size=4096; BEGIN;"
            "CREATE TABLE metadata (name TEXT, value TEXT);"
            "CREATE TABLE tiles (zoom_level INTEGER, tile_column INTEGER, tile_row INTEGER, tile_data BLOB);");
    }
    ~Database() { sqlite3_close(db_); }
    Database(const Database&) = delete;
    Database& operator=(const Database&) = delete;

    void run(const char* sql) { check(sqlite3_exec(db_, sql, nullptr, nullptr, nullptr)); }
    // A statement whose values bind() gives, once.
    template <typename Bind>
    void insert(const char* sql, const Bind& bind) {
        sqlite3_stmt*& statement = statements_[sql];
        if (statement == nullptr) check(sqlite3_prepare_v2(db_, sql, -1, &statement, nullptr));
        bind(statement);
        if (sqlite3_step(statement) != SQLITE_DONE) fail();
        check(sqlite3_reset(statement));
    }
    void close() {
        for (auto& [sql, statement] : statements_) sqlite3_finalize(statement);
        statements_.clear();
        run("CREATE UNIQUE INDEX tile_index ON tiles (zoom_level, tile_column, tile_row); COMMIT;");
        check(sqlite3_close(db_));
        db_ = nullptr;
    }

private:
    void check(int result) {
        if (result != SQLITE_OK) fail();
    }
    [[noreturn]] void fail() {
        throw Failure(
            3, fmt::format("{}: cannot write: {}; is the disk full?", path_, db_ ? sqlite3_errmsg(db_) : "no memory"));
    }
    std::string path_;
    sqlite3* db_ = nullptr;
    std::map<std::string, sqlite3_stmt*> statements_;
};

void write_mbtiles(const std::vector<ArchiveTile>& tiles, const ArchiveAbout& about, const std::string& path,
                   const std::string& unfinished) {
    std::filesystem::remove(unfinished);
    Database database(unfinished);
    const DegreeBox& b = about.bounds;
    const auto levels = std::minmax_element(
        tiles.begin(), tiles.end(), [](const ArchiveTile& p, const ArchiveTile& q) { return p.id.level < q.id.level; });
    const std::vector<std::pair<std::string, std::string>> metadata{
        {"name", about.name},
        {"format", about.format},
        {"type", "baselayer"},
        {"version", "1"},
        {"minzoom", std::to_string(levels.first->id.level)},
        {"maxzoom", std::to_string(levels.second->id.level)},
        {"bounds", fmt::format("{},{},{},{}", b.west, b.south, b.east, b.north)},
        {"json", about.json}};
    const auto text = [](sqlite3_stmt* s, int at, const std::string& value) {
        sqlite3_bind_text(s, at, value.data(), static_cast<int>(value.size()), SQLITE_STATIC);
    };
    for (const auto& [name, value] : metadata)
        database.insert("INSERT INTO metadata VALUES (?, ?)",
                        [&, &n = name, &v = value](sqlite3_stmt* s) { text(s, 1, n), text(s, 2, v); });
    for (const ArchiveTile& tile : tiles) {
        io::check_interrupt();
        const std::string data = io::read_text(tile.path);
        database.insert("INSERT INTO tiles VALUES (?, ?, ?, ?)", [&](sqlite3_stmt* s) {
            sqlite3_bind_int(s, 1, tile.id.level), sqlite3_bind_int(s, 2, tile.id.x), sqlite3_bind_int(s, 3, tile.id.y);
            sqlite3_bind_blob64(s, 4, data.data(), data.size(), SQLITE_STATIC);
        });
    }
    database.close();
    std::error_code error;
    std::filesystem::rename(unfinished, path, error);
    if (error) errno = error.value(), io::disk_failure(path, "write");
}

// ---- PMTiles 3: rows from the north, tiles along a Hilbert curve

std::uint64_t hilbert_place(int level, std::uint32_t x, std::uint32_t y) {
    std::uint64_t place = 0;
    for (std::uint32_t s = level > 0 ? 1u << (level - 1) : 0; s > 0; s /= 2) {
        const std::uint32_t rx = (x & s) != 0, ry = (y & s) != 0;
        place += std::uint64_t{s} * s * ((3 * rx) ^ ry);
        if (ry != 0) continue;
        if (rx != 0) x = s - 1 - (x & (s - 1)), y = s - 1 - (y & (s - 1));
        std::swap(x, y);
    }
    return place;
}
std::uint64_t pmtiles_id(TileId id) {
    const std::uint64_t before = ((std::uint64_t{1} << (2 * id.level)) - 1) / 3; // tiles of coarser levels
    return before + hilbert_place(id.level, static_cast<std::uint32_t>(id.x),
                                  static_cast<std::uint32_t>(tiles_down(id.level) - 1 - id.y));
}

struct Entry {
    std::uint64_t id = 0, offset = 0;
    std::uint32_t length = 0, run = 0; // run 0: the entry is of a leaf directory
};

std::vector<std::byte> directory_of(std::span<const Entry> entries) {
    std::vector<std::byte> bytes;
    const auto put = [&](std::uint64_t value) {
        for (; value >= 0x80; value >>= 7) bytes.push_back(static_cast<std::byte>(value | 0x80));
        bytes.push_back(static_cast<std::byte>(value));
    };
    put(entries.size());
    std::uint64_t last = 0;
    for (const Entry& e : entries) put(e.id - last), last = e.id;
    for (const Entry& e : entries) put(e.run);
    for (const Entry& e : entries) put(e.length);
    for (std::size_t i = 0; i < entries.size(); ++i) {
        const bool follows = i > 0 && entries[i].offset == entries[i - 1].offset + entries[i - 1].length;
        put(follows ? 0 : entries[i].offset + 1);
    }
    return gzip(bytes);
}

struct Directories {
    std::vector<std::byte> root, leaves;
};
// The root is as much as a reader asks for at first. Where all does not fit it, it names leaves.
Directories directories_of(std::span<const Entry> entries) {
    constexpr std::size_t most_root = 16384 - 127;
    Directories d{directory_of(entries), {}};
    for (std::size_t leaf = 4096; d.root.size() > most_root; leaf *= 2) {
        std::vector<Entry> names;
        d.leaves.clear();
        for (std::size_t first = 0; first < entries.size(); first += leaf) {
            const auto part = entries.subspan(first, std::min(leaf, entries.size() - first));
            const std::vector<std::byte> bytes = directory_of(part);
            names.push_back({part.front().id, d.leaves.size(), static_cast<std::uint32_t>(bytes.size()), 0});
            d.leaves.insert(d.leaves.end(), bytes.begin(), bytes.end());
        }
        d.root = directory_of(names);
    }
    return d;
}

void write_pmtiles(std::vector<ArchiveTile> tiles, const ArchiveAbout& about, const std::string& path) {
    std::sort(tiles.begin(), tiles.end(),
              [](const ArchiveTile& a, const ArchiveTile& b) { return pmtiles_id(a.id) < pmtiles_id(b.id); });
    // What was written before is not written again.
    std::vector<Entry> entries;
    std::vector<const ArchiveTile*> contents;
    std::map<std::array<std::uint64_t, 2>, Entry> known;
    std::uint64_t data_bytes = 0;
    for (const ArchiveTile& tile : tiles) {
        io::check_interrupt();
        const std::string data = io::read_text(tile.path);
        const XXH128_hash_t hash = XXH3_128bits(data.data(), data.size());
        const auto [found, fresh] = known.try_emplace({hash.low64, hash.high64});
        if (fresh) {
            found->second = {0, data_bytes, static_cast<std::uint32_t>(data.size()), 1};
            data_bytes += data.size();
            contents.push_back(&tile);
        }
        const std::uint64_t id = pmtiles_id(tile.id);
        if (!entries.empty() && entries.back().offset == found->second.offset &&
            entries.back().id + entries.back().run == id) {
            ++entries.back().run;
        } else {
            entries.push_back(found->second);
            entries.back().id = id;
        }
    }
    const Directories directories = directories_of(entries);
    const std::vector<std::byte> metadata = gzip(as_bytes(about.json));
    constexpr std::size_t header_bytes = 127;
    std::vector<std::byte> header;
    const auto put = [&](auto value) {
        const auto bytes = std::as_bytes(std::span(&value, 1));
        header.insert(header.end(), bytes.begin(), bytes.end());
    };
    std::uint64_t at = header_bytes;
    for (const char c : {'P', 'M', 'T', 'i', 'l', 'e', 's'}) put(c);
    put(std::uint8_t{3});
    for (const std::uint64_t length : {std::uint64_t{directories.root.size()}, std::uint64_t{metadata.size()},
                                       std::uint64_t{directories.leaves.size()}, data_bytes})
        put(at), put(length), at += length;
    put(std::uint64_t{tiles.size()}), put(std::uint64_t{entries.size()}), put(std::uint64_t{contents.size()});
    constexpr std::uint8_t none = 1, gzipped = 2, unknown = 0, png = 2, webp = 4;
    put(std::uint8_t{1}); // along the curve
    put(gzipped), put(about.gzip ? gzipped : none),
        put(about.format == "png"    ? png
            : about.format == "webp" ? webp
                                     : unknown);
    const auto levels = std::minmax_element(
        tiles.begin(), tiles.end(), [](const ArchiveTile& p, const ArchiveTile& q) { return p.id.level < q.id.level; });
    put(static_cast<std::uint8_t>(levels.first->id.level)), put(static_cast<std::uint8_t>(levels.second->id.level));
    const auto degrees = [&](double value) { put(static_cast<std::int32_t>(std::lround(value * 1e7))); };
    const DegreeBox& b = about.bounds;
    degrees(b.west), degrees(b.south), degrees(b.east), degrees(b.north);
    put(static_cast<std::uint8_t>(levels.first->id.level));
    degrees(b.middle().longitude), degrees(b.middle().latitude);

    io::AtomicFile file(path);
    file.write(header), file.write(directories.root), file.write(metadata), file.write(directories.leaves);
    for (const ArchiveTile* tile : contents) {
        io::check_interrupt();
        file.write(as_bytes(io::read_text(tile->path)));
    }
    file.commit();
}

} // namespace

Archive archive_of(const std::string& path) {
    return path.ends_with(".mbtiles")   ? Archive::mbtiles
           : path.ends_with(".pmtiles") ? Archive::pmtiles
                                        : Archive::folder;
}

void write_archive(Archive kind, const std::vector<ArchiveTile>& tiles, const ArchiveAbout& about,
                   const std::string& path, const std::string& work) {
    if (kind == Archive::mbtiles) write_mbtiles(tiles, about, path, work + "/unfinished.mbtiles");
    if (kind == Archive::pmtiles) write_pmtiles(tiles, about, path);
}

} // namespace fjell::baker
