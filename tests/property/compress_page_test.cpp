// How pages are compressed: what a reader of zstd makes of a frame, and which bytes are stored as they are.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <zstd.h>

#include "baker/pack/compress_page.h"
#include "support/rounds.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::test;

namespace {

using Bytes = baker::Buffer<std::byte>;

// values: how many different ones there may be.
void append_bytes(Random& random, std::size_t count, int values, Bytes& to) {
    for (std::size_t i = 0; i < count; ++i) to.push_back(static_cast<std::byte>(pick(random, 0, values - 1)));
}

[[nodiscard]] Bytes decompressed(const Bytes& frame, std::size_t from, std::size_t expected) {
    Bytes out(expected + 1); // a byte too many would be seen
    const std::size_t size = ZSTD_decompress(out.data(), out.size(), frame.data() + from, frame.size() - from);
    REQUIRE(!ZSTD_isError(size));
    out.resize(size);
    return out;
}

[[nodiscard]] Bytes whole_frame(const Bytes& page) {
    Bytes out(ZSTD_compressBound(page.size()));
    out.resize(ZSTD_compress(out.data(), out.size(), page.data(), page.size(), 1));
    return out;
}

} // namespace

TEST_CASE("a page's frame is one that zstd reads, whatever the page, and says how long it is") {
    Random random(171);
    int stored = 0;
    for (int round = 0; round < rounds(200, 5'000); ++round) {
        Bytes page;
        auto low_end = static_cast<std::size_t>(pick(random, 1, pick(random, 0, 1) ? 300 : 3'144));
        append_bytes(random, low_end, pick(random, 0, 1) ? 256 : pick(random, 1, 100), page);
        const std::size_t rest = round == 0   ? 70'000
                                 : round == 1 ? 256
                                              : static_cast<std::size_t>(pick(random, 1, 6'000));
        append_bytes(random, rest, pick(random, 1, 4), page);
        if (round == 1) page.resize(256), low_end = std::min(low_end, page.size());
        Bytes to(static_cast<std::size_t>(pick(random, 0, 3)), std::byte{7}); // frames are appended
        const std::size_t from = to.size();
        baker::compress_page(page, low_end, to);
        CAPTURE(round, low_end, rest);
        REQUIRE(ZSTD_getFrameContentSize(to.data() + from, to.size() - from) == page.size());
        REQUIRE(ZSTD_findFrameCompressedSize(to.data() + from, to.size() - from) == to.size() - from);
        REQUIRE(decompressed(to, from, page.size()) == page);
        stored += std::search(to.begin(), to.end(), page.begin(),
                              page.begin() + static_cast<std::ptrdiff_t>(low_end)) != to.end();
    }
    CHECK(stored > 40);
}

TEST_CASE("low bytes of noise are stored as they are, in fewer bytes than one zstd block takes, and others are not") {
    Random random(172);
    for (const int values : {1, 4, 40, 120, 256}) {
        CAPTURE(values);
        Bytes page, frame;
        append_bytes(random, 3'144, values, page);
        append_bytes(random, 3'344, 2, page);
        baker::compress_page(page, 3'144, frame);
        const bool stored = std::search(frame.begin(), frame.end(), page.begin(), page.begin() + 3'144) != frame.end();
        CHECK(stored == (values > 80));
        if (values == 256) CHECK(frame.size() < whole_frame(page).size());
    }
}

TEST_CASE("what follows low bytes that are stored may have matches where they save much") {
    Random random(173);
    Bytes page, frame;
    append_bytes(random, 3'144, 256, page);
    for (int i = 0; i < 3'344; ++i) page.push_back(static_cast<std::byte>(i % 200 == 0));
    baker::compress_page(page, 3'144, frame);
    CHECK(frame.size() < 3'144 + 100); // by codes of bytes alone a bit each at least: 418
    CHECK(decompressed(frame, 0, page.size()) == page);
}
