// A page's decoder with no hash and no zstd in its way: any bytes for any page of any order and tile size end in
// records or in `corrupt`. Everything is done twice, into arrays that were filled differently: what is read before it
// is written, and what is written beyond a page's vertices, shows as a difference.
#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>

#include "input.h"
#include "shared/page.h"

namespace {

using namespace fjell;
using fuzz::must;
using fuzz::PageScript;

constexpr std::uint32_t n = page_squares, w = page_corners;
constexpr std::uint32_t first_side_x = n * n, first_side_y = first_side_x + n * (n + 1);

// The length that a page's flags ask for, said once more and in other words than in unpack_page.
std::size_t raw_bytes(const PageLayout& pages, std::uint32_t page, unsigned flags) {
    const std::size_t count = pages.page_vertices(page);
    return sizeof(PageHead) + count * (1u + (flags & page_wide ? 1 : 0) + (flags & page_errors ? 1 : 0)) +
           (is_step_page(pages, page) ? page_radii : count) + (flags & page_voids ? (count + 7) / 8 : 0);
}

// Exactly as long as it is: one byte further is the sanitizer's.
struct Raw {
    std::unique_ptr<std::byte[]> bytes;
    std::size_t size = 0;
    explicit Raw(std::span<const std::byte> from, std::size_t the_size)
        : bytes(std::make_unique<std::byte[]>(the_size)), size(the_size) {
        std::copy_n(from.begin(), std::min(from.size(), size), bytes.get());
    }
    [[nodiscard]] std::span<const std::byte> span() const { return {bytes.get(), size}; }
};

bool unpacks(const PageLayout& pages, std::uint32_t page, std::span<const std::byte> from, std::size_t size) {
    static PageArrays out;
    return unpack_page(pages, page, Raw(from, size).span(), out).ok();
}

// The scales' extremes that check_ranges lets through, and the usual one.
struct Scale {
    ErrorScale errors;
    LeafErrors leaf;
    Scale(float floor_m, float ratio, std::uint32_t nesting_steps, float quantum_m)
        : errors(ErrorScale::make(floor_m, ratio, nesting_steps)), leaf(errors, quantum_m) {}
};
const Scale& scale_of(std::uint8_t choice) {
    static const Scale scales[] = {
        {0.05f, 1.05f, 1, 0.1f}, {1e-9f, 1.0001f, 255, 1e4f}, {1e9f, 1.2f, 1, 1e-9f}, {1e-9f, 1.2f, 14, 1e4f}};
    return scales[choice % std::size(scales)];
}

void check_equal(const PageArrays& a, const PageArrays& b, std::uint32_t count, bool errors_too) {
    must(a.base == b.base && a.errors_derived == b.errors_derived, "a page's head is decoded alike");
    must(std::equal(a.heights, a.heights + count, b.heights), "heights follow from the bytes alone");
    must(std::equal(a.radii, a.radii + count, b.radii), "radii follow from the bytes alone");
    if (errors_too) must(std::equal(a.errors, a.errors + count, b.errors), "errors follow from the bytes alone");
}

template <typename T>
bool untouched(const T* rest, const T* end, int fill) {
    T filled;
    std::memset(&filled, fill, sizeof filled);
    return std::all_of(rest, end, [&](T value) { return value == filled; });
}
void check_rest(const PageArrays& a, std::uint32_t count, int fill) {
    must(untouched(a.heights + count, std::end(a.heights), fill) &&
             untouched(a.errors + (a.errors_derived ? 0 : count), std::end(a.errors), fill) &&
             untouched(a.radii + count, std::end(a.radii), fill),
         "nothing is written beyond a page's vertices");
}

void check_derived(const PageScript& script, PageArrays& a, PageArrays& b) {
    CornerSteps corners;
    for (std::uint32_t i = 0; i < std::size(corners); ++i)
        corners[i] = static_cast<std::int32_t>((script.corner_first + i * script.corner_stride) %
                                               (static_cast<std::uint32_t>(max_height_steps) + 1));
    const Scale& scale = scale_of(script.scale);
    derive_errors(corners, scale.errors, scale.leaf, a);
    derive_errors(corners, scale.errors, scale.leaf, b);
    check_equal(a, b, max_page_vertices, true);
    for (std::uint32_t j = 0; j < n; ++j)
        for (std::uint32_t i = 0; i < n; ++i) {
            const std::uint8_t *const x = a.errors + first_side_x + j * n + i, *const y =
                                                                                   a.errors + first_side_y + j * w + i;
            const std::uint32_t child = std::max({x[0], x[n], y[0], y[1]});
            must(a.errors[j * n + i] >= std::min(scale.errors.above(child), 255u), "a centre's error nests its sides'");
        }
}

} // namespace

extern "C" int fuzz_page(const std::uint8_t* data, std::size_t size) {
    PageScript script;
    if (size < sizeof script) return 0;
    std::memcpy(&script, data, sizeof script);
    const PageLayout pages{1 + script.layout / 3 % 8, static_cast<PageOrder>(script.layout % 3)};
    const std::uint32_t page = script.page % pages.pages_per_tile(), count = pages.page_vertices(page);
    const auto input = std::as_bytes(std::span(data, size)).subspan(sizeof script);
    const unsigned flags = input.size() < sizeof(PageHead) ? 0 : std::to_integer<unsigned>(input[4]);
    const Raw raw(input, script.fit & 1 ? raw_bytes(pages, page, flags) : input.size());

    static PageArrays a, b; // too large for some stacks
    constexpr int fill_a = 0x00, fill_b = 0xa5;
    std::memset(static_cast<void*>(&a), fill_a, sizeof a);
    std::memset(static_cast<void*>(&b), fill_b, sizeof b);
    b.errors_derived = false; // 0xa5 is no bool
    const bool ok = unpack_page(pages, page, raw.span(), a).ok();
    must(unpack_page(pages, page, raw.span(), b).ok() == ok, "a page is refused or not by its bytes alone");
    if (!ok) return 0;
    must(raw.size == raw_bytes(pages, page, flags), "a page is as long as its flags say");
    must(!unpacks(pages, page, input, raw.size - 1) && !unpacks(pages, page, input, raw.size + 1),
         "no page is a byte shorter or longer");
    must(a.base >= 0 && a.base <= max_height_steps - 65535, "a page's heights lie on the height scale");
    must(!a.errors_derived || pages.page_step_log2(page) == 0, "only errors of the finest step are derived");
    must((flags & page_voids) || std::none_of(a.radii, a.radii + count, [](auto r) { return r & void_bit; }),
         "a page without holes has none");
    check_equal(a, b, count, !a.errors_derived);
    check_rest(a, count, fill_a);
    check_rest(b, count, fill_b);
    if (a.errors_derived) check_derived(script, a, b);
    return 0;
}
