#include "baker/pack/compress_page.h"

#include <cstdint>
#include <memory>

#include <fmt/format.h>
#define ZSTD_STATIC_LINKING_ONLY // frames of given matches
#include <zstd.h>

#include "fjell/io/failure.h"

namespace fjell::baker {

namespace {

using Bytes = Buffer<std::byte>;

// One a thread. Residuals of heights hold few matches: looking for long ones only takes no more bytes, and leaves the
// decoder fewer.
ZSTD_CCtx* page_compressor() {
    thread_local const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(), ZSTD_freeCCtx);
    if (!context) throw io::Failure(3, "cannot compress: not enough memory");
    ZSTD_CCtx_reset(context.get(), ZSTD_reset_session_and_parameters);
    ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, 1);
    ZSTD_CCtx_setParameter(context.get(), ZSTD_c_minMatch, 7);
    return context.get();
}

// Appends a frame. sized: it says how long its content is.
void append_frame(std::span<const std::byte> from, bool sized, Bytes& to) {
    ZSTD_CCtx* const context = page_compressor();
    ZSTD_CCtx_setParameter(context, ZSTD_c_contentSizeFlag, sized);
    const std::size_t at = to.size();
    to.resize(at + ZSTD_compressBound(from.size()));
    const std::size_t size = ZSTD_compress2(context, to.data() + at, to.size() - at, from.data(), from.size());
    if (ZSTD_isError(size)) throw io::Failure(3, fmt::format("cannot compress: {}", ZSTD_getErrorName(size)));
    to.resize(at + size);
}
// The same without matches, codes of bytes alone. False: this zstd cannot.
[[nodiscard]] bool append_matchless_frame(std::span<const std::byte> from, Bytes& to) {
    ZSTD_CCtx* const context = page_compressor();
    ZSTD_CCtx_setParameter(context, ZSTD_c_contentSizeFlag, 0);
    ZSTD_CCtx_setParameter(context, ZSTD_c_blockDelimiters, ZSTD_sf_explicitBlockDelimiters);
    const ZSTD_Sequence all{0, static_cast<unsigned>(from.size()), 0, 0};
    const std::size_t at = to.size();
    to.resize(at + ZSTD_compressBound(from.size()));
    const std::size_t size =
        ZSTD_compressSequences(context, to.data() + at, to.size() - at, &all, 1, from.data(), from.size());
    to.resize(ZSTD_isError(size) ? at : at + size);
    return !ZSTD_isError(size);
}

void put(std::uint32_t value, std::size_t bytes, Bytes& to) {
    for (std::size_t i = 0; i < bytes; ++i) to.push_back(static_cast<std::byte>(value >> (8 * i)));
}

// zstd's format (RFC 8878): a frame is a header and blocks, of which the last is marked; each says by itself how it is
// stored.
constexpr std::size_t unsized_header = 6;                         // magic number, descriptor, window
constexpr std::size_t least_size = 256, most_size = 256 + 0xffff; // of the content, in two bytes of the header
constexpr std::uint32_t frame_magic = 0xFD2FB528, frame_descriptor = 0x60;

// Whether zstd's codes save a tenth or less: where as many values would be met as equally likely ones. Counted, because
// compressing to find out takes a twentieth of a bake; in whole numbers, so that every machine decides alike.
[[nodiscard]] bool hardly_shrinks(std::span<const std::byte> bytes) {
    constexpr std::uint64_t values = 80;
    std::uint32_t count[2][256] = {}; // two, because counting one value twice in a row waits
    const auto see = [&](std::size_t i) { ++count[i % 2][std::to_integer<std::size_t>(bytes[i])]; };
    for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) see(i), see(i + 1);
    if (bytes.size() % 2 != 0) see(bytes.size() - 1);
    std::uint64_t squares = 0;
    for (std::size_t v = 0; v < 256; ++v) {
        const std::uint64_t both = std::uint64_t{count[0][v]} + count[1][v];
        squares += both * both;
    }
    return std::uint64_t{bytes.size()} * bytes.size() >= values * squares;
}

// What follows low bytes that are stored as they are, as a frame without its content's size. Without matches where that
// costs the page less than a thirty-second: high bytes are few different ones, matches among them short and by chance,
// and making copies of them takes a reader longer than decoding them.
void compress_rest(std::span<const std::byte> rest, std::size_t low_end, Bytes& frame) {
    thread_local Bytes matchless;
    frame.clear();
    append_frame(rest, false, frame);
    matchless.clear();
    if (append_matchless_frame(rest, matchless) && 32 * (low_end + matchless.size()) <= 33 * (low_end + frame.size()))
        frame.swap(matchless);
}

} // namespace

void compress_page(std::span<const std::byte> page, std::size_t low_end, Buffer<std::byte>& to) {
    const bool short_header = page.size() >= least_size && page.size() <= most_size;
    if (short_header && hardly_shrinks(page.first(low_end))) {
        thread_local Bytes scratch;
        compress_rest(page.subspan(low_end), low_end, scratch);
        if (scratch[sizeof frame_magic] == std::byte{0}) { // its header is as long as it should be
            put(frame_magic, sizeof frame_magic, to);
            put(frame_descriptor, 1, to);
            put(static_cast<std::uint32_t>(page.size() - least_size), 2, to);
            put(static_cast<std::uint32_t>(low_end) << 3, 3, to); // a block that is stored as it is, and not the last
            to.insert(to.end(), page.begin(), page.begin() + static_cast<std::ptrdiff_t>(low_end));
            to.insert(to.end(), scratch.begin() + unsized_header, scratch.end());
            return;
        }
    }
    append_frame(page, true, to);
}

} // namespace fjell::baker
