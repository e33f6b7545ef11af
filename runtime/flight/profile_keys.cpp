#include "flight/profile_keys.h"

#include <iterator>
#include <vector>

#include "flight/methods/method.h"
#include "flight/profile_fields.h"

namespace fjell::flight {

namespace {

// One key for both methods' vertex buffers: only one of them is made.
struct Vertices {
    static double get(const Profile& p) { return facts_of(p).vertices(p); }
    static void set(Profile& p, double value) {
        p.budget.vertices = p.cut_budget.vertices = static_cast<std::uint32_t>(value);
    }
};

struct Items {
    static double get(const Profile& p) { return p.cut.items == unlimited_items ? 0 : p.cut.items; }
    static void set(Profile& p, double value) {
        p.cut.items = value == 0 ? unlimited_items : static_cast<std::uint32_t>(value);
    }
};

// In the order of the enumerations.
constexpr const char* methods[] = {"incremental", "recursive"};
constexpr const char* morphs[] = {"none", "error", "time"};
constexpr const char* metrics[] = {"isotropic", "depth"};
constexpr const char* topologies[] = {"list", "strip"};
static_assert(static_cast<int>(Method::recursive) == 1 && static_cast<int>(Morph::error) == 1 &&
                  static_cast<int>(Morph::time) == 2 && static_cast<int>(Metric::depth) == 1 &&
                  static_cast<int>(Topology::strip) == 1,
              "choices are named in the order of their values: change the names above too");

constexpr ProfileTable tables[] = {
    {"refine", "Refinement"},
    {"budget", "Budgets"},
    {"stream", "Streaming",
     "Streaming (--stream on, or auto with a pack of more pages than page_slots): pages of geometry and mips of maps "
     "are read when the views want them."},
    {"view", "View"},
    {"light", "Light and air"},
    {"layers", "Detail layers"},
};

constexpr auto whole = KeyKind::whole, flag = KeyKind::flag, choice = KeyKind::choice;

constexpr ProfileKey keys_before_light[] = {
    {.table = "refine",
     .name = "method",
     .label = "Method",
     .kind = choice,
     .choices = methods,
     .about = "How the mesh is updated. \"incremental\": kept from frame to frame, refined all around the eye; costs "
              "what changes, 100 to 400 ns a work item, and next to nothing while the camera rests or turns. "
              "\"recursive\": rebuilt from the roots in every frame; 30 to 90 ns a selected vertex, and only those "
              "in view are selected, about a quarter.",
     .rebuild = Rebuild::method,
     .get = At<&Profile::method>::get,
     .set = At<&Profile::method>::set},
    {.table = "refine",
     .name = "error_px",
     .label = "Threshold",
     .unit = "px",
     .least = min_error_px,
     .most = max_error_px,
     .logarithmic = true,
     .about = "Threshold: the largest error on screen. Pixels, 0.01 to 1000. Halving it takes 2 to 3.5 times the "
              "vertices and the time.",
     .get = At<&Profile::refine, &RefineSettings::error_px>::get,
     .set = At<&Profile::refine, &RefineSettings::error_px>::set},
    {.table = "refine",
     .name = "corner_safe",
     .label = "Hold in corners",
     .kind = flag,
     .about =
         "Hold the threshold in pixels in the image's corners too, not only as an angle: true or false. Divides it by "
         "1.48 for a picture of 4:3 at 45 degrees, by 1.71 for one of 16:9: about 1.7 and 2.1 times the vertices.",
     .get = At<&Profile::refine, &RefineSettings::corner_safe>::get,
     .set = At<&Profile::refine, &RefineSettings::corner_safe>::set},
    {.table = "refine",
     .name = "hysteresis",
     .label = "Hysteresis",
     .most = max_hysteresis,
     .zero = "none",
     .about = "A vertex is activated at error_px and deactivated below error_px / (1 + hysteresis). No unit, 0 to 10. "
              "0.3 takes a tenth more vertices and makes a third fewer changes. (Incremental.)",
     .used_by = UsedBy::incremental,
     .get = At<&Profile::cut, &CutSettings::hysteresis>::get,
     .set = At<&Profile::cut, &CutSettings::hysteresis>::set},
    {.table = "refine",
     .name = "offscreen_factor",
     .label = "Off-screen",
     .least = 1,
     .most = max_offscreen_factor,
     .logarithmic = true,
     .about = "What no view sees, nor soon will, is refined to error_px times this. No unit, 1 to 100. 1 refines all "
              "around: turning costs nothing. 8 takes 0.3 to 0.7 of the vertices, and as much of the time of a flight "
              "straight on; turning then refines what comes into sight, and an export is coarse where nobody looked. "
              "(Incremental.)",
     .used_by = UsedBy::incremental,
     .get = At<&Profile::cut, &CutSettings::offscreen_factor>::get,
     .set = At<&Profile::cut, &CutSettings::offscreen_factor>::set},
    {.table = "refine",
     .name = "morph",
     .label = "Morph",
     .kind = choice,
     .most = 2,
     .choices = morphs,
     .about = "How vertices appear and disappear. \"none\": at once. \"error\": they morph with the distance; takes a "
              "seventh more vertices. \"time\": they morph over morph_s seconds; the threshold holds only where "
              "nothing is morphing any more. (Incremental.)",
     .used_by = UsedBy::incremental,
     .get = At<&Profile::cut, &CutSettings::morph>::get,
     .set = At<&Profile::cut, &CutSettings::morph>::set},
    {.table = "refine",
     .name = "morph_s",
     .label = "Morph time",
     .unit = "s",
     .least = min_morph_s,
     .most = max_morph_s,
     .logarithmic = true,
     .about = "Time that a vertex activated late takes to morph. Seconds, 0.01 to 10. Costs a write and an upload of "
              "28 bytes for each such vertex. (Incremental.)",
     .used_by = UsedBy::incremental,
     .get = At<&Profile::cut, &CutSettings::morph_s>::get,
     .set = At<&Profile::cut, &CutSettings::morph_s>::set},
    {.table = "refine",
     .name = "metric",
     .label = "Metric",
     .kind = choice,
     .choices = metrics,
     .about = "What an error is divided by: the \"isotropic\" distance to the eye, or the \"depth\" along the view "
              "(thesis 5.4.1; needs cull = true). Depth holds the bound in the image's corners too where the view is "
              "level, for a tenth more vertices. (Recursive.)",
     .used_by = UsedBy::recursive,
     .get = At<&Profile::refine, &RefineSettings::metric>::get,
     .set = At<&Profile::refine, &RefineSettings::metric>::set},
    {.table = "refine",
     .name = "cull",
     .label = "Only in view",
     .kind = flag,
     .about = "Leave out vertices outside the view frustum: true or false. False refines all around, for about four "
              "times the vertices at 45 degrees; turning the head then changes nothing. (Recursive; the incremental "
              "method refines all around and draws the tiles that may be seen.)",
     .used_by = UsedBy::recursive,
     .get = At<&Profile::refine, &RefineSettings::cull>::get,
     .set = At<&Profile::refine, &RefineSettings::cull>::set},
    {.table = "refine",
     .name = "topology",
     .label = "Topology",
     .kind = choice,
     .choices = topologies,
     .about = "\"list\": an indexed triangle list, three indices a triangle. \"strip\": one strip a tile, as in the "
              "thesis, about 0.6 of the indices. (Recursive.)",
     .used_by = UsedBy::recursive,
     .get = At<&Profile::refine, &RefineSettings::topology>::get,
     .set = At<&Profile::refine, &RefineSettings::topology>::set},

    {.table = "budget",
     .name = "vertices",
     .label = "Vertices",
     .kind = whole,
     .unit = "vertices",
     .least = min_budget,
     .most = max_vertices,
     .logarithmic = true,
     .about = "Slots of the vertex buffer. Vertices, 16 to 134217728. 57 bytes each for the incremental method, 28 on "
              "the GPU, and 19.7 KB for 64 of them as far as there are pages; 20 and 12 for the recursive one, which "
              "needs a quarter to a sixth as many. When they do not "
              "suffice, the threshold rises, the mesh stays crack-free, and the report says \"vertices\".",
     .rebuild = Rebuild::method,
     .get = Vertices::get,
     .set = Vertices::set},
    {.table = "budget",
     .name = "triangles",
     .label = "Triangles",
     .kind = whole,
     .unit = "triangles",
     .least = min_budget,
     .most = max_triangles,
     .logarithmic = true,
     .about =
         "Slots of the index buffer. Triangles, 16 to 536870912. 12 bytes each, on the GPU, too. About two "
         "an active vertex, and up to an eighth of them is idle in half-full segments. When they do not suffice, the "
         "threshold rises and the report says \"triangles\". (Incremental.)",
     .rebuild = Rebuild::method,
     .used_by = UsedBy::incremental,
     .get = At<&Profile::cut_budget, &CutBudget::triangles>::get,
     .set = At<&Profile::cut_budget, &CutBudget::triangles>::set},
    {.table = "budget",
     .name = "views",
     .label = "Views",
     .kind = whole,
     .unit = "views",
     .least = 1,
     .most = max_cut_views,
     .about = "Views that share one mesh: split screen, shadows. Views, 1 to 8. They take hardly any memory; each one "
              "adds its distances to every evaluation. fjell-fly gives one. (Incremental.)",
     .rebuild = Rebuild::method,
     .used_by = UsedBy::incremental,
     .get = At<&Profile::cut_budget, &CutBudget::views>::get,
     .set = At<&Profile::cut_budget, &CutBudget::views>::set},
    {.table = "budget",
     .name = "workers",
     .label = "Building threads",
     .kind = whole,
     .least = 1,
     .most = max_cut_workers,
     .about = "Threads that build what the camera sees in the first frame and after a jump, with the frame's own; the "
              "mesh does not depend on it. 1 to 64. 160 KB each with tiles of 513. (Incremental.)",
     .rebuild = Rebuild::method,
     .used_by = UsedBy::incremental,
     .get = At<&Profile::cut_budget, &CutBudget::workers>::get,
     .set = At<&Profile::cut_budget, &CutBudget::workers>::set},
    {.table = "budget",
     .name = "items",
     .label = "Work items a frame",
     .kind = whole,
     .unit = "items",
     .most = max_items,
     .logarithmic = true,
     .zero = "no limit",
     .about =
         "Work that a frame may do: groups evaluated, vertices activated or deactivated. Items, 0 to 4294967294; 0: no "
         "limit. An item takes 100 to 400 ns, depending on the cache. When they do not suffice, the mesh lags behind "
         "the camera and the report says \"items\". (Incremental; building the first frame is not bounded.)",
     .used_by = UsedBy::incremental,
     .get = Items::get,
     .set = Items::set},
    {.table = "budget",
     .name = "budget_us",
     .label = "Time an update",
     .unit = "us",
     .most = max_budget_us,
     .logarithmic = true,
     .zero = "no limit",
     .about = "Time that an update may take. Microseconds, 0 to 1000000; 0: no limit. The clock is read every few "
              "items, so it is exceeded by some microseconds at most; but no two runs are alike. The report says "
              "\"time\". (Incremental.)",
     .used_by = UsedBy::incremental,
     .get = At<&Profile::cut, &CutSettings::budget_us>::get,
     .set = At<&Profile::cut, &CutSettings::budget_us>::set},
    {.table = "budget",
     .name = "indices",
     .label = "Indices",
     .kind = whole,
     .unit = "indices",
     .least = min_budget,
     .most = max_indices,
     .logarithmic = true,
     .about = "Indices of one frame. Indices, 16 to 1073741824. 4 bytes each, and as many on the GPU, all uploaded in "
              "every frame. A list needs about 6 a selected vertex, strips 3.5. When they do not suffice, the report "
              "says \"indices\". (Recursive.)",
     .rebuild = Rebuild::method,
     .used_by = UsedBy::recursive,
     .get = At<&Profile::budget, &RecursiveBudget::indices>::get,
     .set = At<&Profile::budget, &RecursiveBudget::indices>::set},

    {.table = "stream",
     .name = "page_slots",
     .label = "Page slots",
     .kind = whole,
     .unit = "pages",
     .least = 1,
     .most = max_page_slots,
     .logarithmic = true,
     .about =
         "Pages in memory at a time. Pages, 1 to 16777216; at least one a tile of the pack. 12.5 KB each. When they do "
         "not suffice, the terrain is coarser where its error shows least, and the report says \"page_slots\".",
     .rebuild = Rebuild::session,
     .used_by = UsedBy::streaming,
     .get = At<&Profile::page_slots>::get,
     .set = At<&Profile::page_slots>::set},
    {.table = "stream",
     .name = "page_requests",
     .label = "Page requests",
     .kind = whole,
     .unit = "pages",
     .least = 1,
     .most = max_page_requests,
     .logarithmic = true,
     .about = "Page requests in flight. Pages, 1 to 256; some 16 KB each. Fewer follow a turn of the head sooner, more "
              "keep a disk of high latency busy.",
     .rebuild = Rebuild::session,
     .used_by = UsedBy::streaming,
     .get = At<&Profile::stream_budget, &StreamBudget::page_requests>::get,
     .set = At<&Profile::stream_budget, &StreamBudget::page_requests>::set},
    {.table = "stream",
     .name = "map_requests",
     .label = "Mip requests",
     .kind = whole,
     .unit = "mips",
     .least = 1,
     .most = max_map_requests,
     .logarithmic = true,
     .about = "Map requests in flight. Mips, 1 to 64. Each takes the bytes of the pack's largest mip, 525 KB for 1024 "
              "texels of colour.",
     .rebuild = Rebuild::session,
     .used_by = UsedBy::streaming,
     .get = At<&Profile::stream_budget, &StreamBudget::map_requests>::get,
     .set = At<&Profile::stream_budget, &StreamBudget::map_requests>::set},
    {.table = "stream",
     .name = "map_mb",
     .label = "Maps on the GPU",
     .kind = whole,
     .unit = "MB",
     .least = 1,
     .most = max_map_mb,
     .logarithmic = true,
     .about = "Maps on the GPU. MB (1048576 bytes), 1 to 65536; at least the smallest size of all tiles. When they do "
              "not suffice, maps are blurrier where it shows least, and the report says \"map_bytes\".",
     .rebuild = Rebuild::session,
     .used_by = UsedBy::streaming,
     .get = At<&Profile::stream_budget, &StreamBudget::map_bytes, 20>::get,
     .set = At<&Profile::stream_budget, &StreamBudget::map_bytes, 20>::set},
    {.table = "stream",
     .name = "tail_log2",
     .label = "Smallest map size, log2",
     .kind = whole,
     .least = min_tail_log2,
     .most = max_texture_log2,
     .about = "Map size that every tile always has, read before all others: a power of two texels a side, 2 to 12. One "
              "more takes four times the bytes: 2.7 KB of colour and 5.5 of normals a tile for 6.",
     .rebuild = Rebuild::session,
     .used_by = UsedBy::streaming,
     .get = At<&Profile::stream_budget, &StreamBudget::tail_log2>::get,
     .set = At<&Profile::stream_budget, &StreamBudget::tail_log2>::set},
    {.table = "stream",
     .name = "decoders",
     .label = "Reading threads",
     .kind = whole,
     .least = 1,
     .most = most_decoders,
     .about = "Threads that read and decompress what the views want, beside the frame's. 1 to 16; one decodes some 400 "
              "million samples a second. 160 KB each.",
     .rebuild = Rebuild::session,
     .used_by = UsedBy::streaming,
     .get = At<&Profile::stream_budget, &StreamBudget::decoders>::get,
     .set = At<&Profile::stream_budget, &StreamBudget::decoders>::set},
    {.table = "stream",
     .name = "texel_px",
     .label = "Texel size",
     .unit = "px",
     .least = min_texel_px,
     .most = max_texel_px,
     .logarithmic = true,
     .about =
         "Pixels that a texel of a map may cover. Pixels, 0.1 to 100. 2 instead of 1 reads a quarter of the bytes.",
     .used_by = UsedBy::streaming,
     .get = At<&Profile::stream, &StreamSettings::texel_px>::get,
     .set = At<&Profile::stream, &StreamSettings::texel_px>::set},
    {.table = "stream",
     .name = "lookahead_s",
     .label = "Look ahead",
     .unit = "s",
     .most = max_lookahead_s,
     .zero = "not at all",
     .about = "How far ahead the camera's motion is predicted. Seconds, 0 to 10; 0: not at all. Prefetches what is on "
              "the way, and some that is never wanted.",
     .used_by = UsedBy::streaming,
     .get = At<&Profile::stream, &StreamSettings::lookahead_s>::get,
     .set = At<&Profile::stream, &StreamSettings::lookahead_s>::set},
    {.table = "stream",
     .name = "fade_s",
     .label = "Fade in",
     .unit = "s",
     .most = max_fade_s,
     .zero = "at once",
     .about = "Time in which a new mip fades in. Seconds, 0 to 10; 0: at once. Costs nothing.",
     .used_by = UsedBy::streaming,
     .get = At<&Profile::stream, &StreamSettings::fade_s>::get,
     .set = At<&Profile::stream, &StreamSettings::fade_s>::set},
    {.table = "stream",
     .name = "pages",
     .label = "Pages a frame",
     .kind = whole,
     .unit = "pages",
     .least = 1,
     .most = max_stream_pages,
     .logarithmic = true,
     .about = "Pages inserted in a frame. Pages, 1 to 4096; 10 to 20 us each. When they do not suffice, the rest waits "
              "for the next frame, and the report says \"stream_pages\".",
     .used_by = UsedBy::streaming,
     .get = At<&Profile::stream, &StreamSettings::pages>::get,
     .set = At<&Profile::stream, &StreamSettings::pages>::set},
    {.table = "stream",
     .name = "tests",
     .label = "Pages looked at a frame",
     .kind = whole,
     .unit = "pages",
     .least = min_stream_tests,
     .most = 0xffffffff,
     .logarithmic = true,
     .about = "Pages that a frame may test to find what is wanted. Pages, 1024 to 4294967295; some 10 ns each. When "
              "they do not suffice, the search goes on in the next frame, and the report says \"stream_tests\".",
     .used_by = UsedBy::streaming,
     .get = At<&Profile::stream, &StreamSettings::tests>::get,
     .set = At<&Profile::stream, &StreamSettings::tests>::set},
    {.table = "stream",
     .name = "map_kb",
     .label = "Map uploads a frame",
     .kind = whole,
     .unit = "KB",
     .least = 1,
     .most = max_map_kb,
     .logarithmic = true,
     .about = "Maps uploaded in a frame, but always at least one mip. KB (1024 bytes), 1 to 1048576. Too much costs a "
              "hitch. The report says \"stream_upload\" when more has arrived.",
     .used_by = UsedBy::streaming,
     .get = At<&Profile::stream, &StreamSettings::map_bytes, 10>::get,
     .set = At<&Profile::stream, &StreamSettings::map_bytes, 10>::set},

    {.table = "view",
     .name = "width_px",
     .label = "Width",
     .kind = whole,
     .unit = "px",
     .least = 1,
     .most = max_size_px,
     .about = "Picture's width. Pixels, 1 to 16384. Drawing costs with the area.",
     .get = At<&Profile::width_px>::get,
     .set = At<&Profile::width_px>::set},
    {.table = "view",
     .name = "height_px",
     .label = "Height",
     .kind = whole,
     .unit = "px",
     .least = 1,
     .most = max_size_px,
     .about = "Picture's height. Pixels, 1 to 16384. Vertices grow with it at an equal threshold; drawing costs with "
              "the area.",
     .get = At<&Profile::height_px>::get,
     .set = At<&Profile::height_px>::set},
    {.table = "view",
     .name = "fov_deg",
     .label = "Field of view",
     .unit = "deg",
     .least = min_fov_deg,
     .most = max_fov_deg,
     .about = "Vertical field of view. Degrees, 1 to 150. A narrower one magnifies: 30 instead of 45 takes a quarter "
              "more vertices.",
     .get = At<&Profile::fov_deg>::get,
     .set = At<&Profile::fov_deg>::set},
    {.table = "view",
     .name = "samples",
     .label = "Samples a pixel",
     .kind = whole,
     .unit = "samples",
     .least = 1,
     .most = max_samples,
     .about = "Samples a pixel that smooth edges (MSAA). Samples, 1 to 16; no more than the GPU has. 4 take 32 bytes a "
              "pixel, and in software nearly twice the time. fjell-fly's pictures and window; the editor's has one.",
     .get = At<&Profile::samples>::get,
     .set = At<&Profile::samples>::set},
};

} // namespace

std::span<const ProfileKey> profile_keys() {
    static const std::vector<ProfileKey> keys = [] {
        std::vector<ProfileKey> all(std::begin(keys_before_light), std::end(keys_before_light));
        all.insert(all.end(), light_keys().begin(), light_keys().end());
        all.insert(all.end(), layers_keys().begin(), layers_keys().end());
        return all;
    }();
    return keys;
}

std::span<const ProfileTable> profile_tables() {
    return tables;
}

const ProfileKey* find_profile_key(std::string_view dotted) {
    const std::size_t dot = dotted.find('.');
    if (dot == std::string_view::npos) return nullptr;
    for (const ProfileKey& key : profile_keys())
        if (dotted.substr(0, dot) == key.table && dotted.substr(dot + 1) == key.name) return &key;
    return nullptr;
}

std::vector<const ProfileKey*> differing_keys(const Profile& a, const Profile& b) {
    std::vector<const ProfileKey*> differing;
    for (const ProfileKey& key : profile_keys())
        if (key.get(a) != key.get(b)) differing.push_back(&key);
    return differing;
}

} // namespace fjell::flight
