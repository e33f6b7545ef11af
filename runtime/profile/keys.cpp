#include "fjell/profile/keys.h"

#include <cstdint>
#include <type_traits>
#include <vector>

namespace fjell {

namespace {

using Light = gl::LightSettings;
using Layers = gl::LayerSettings;

// Where a value lies in a profile: a field, or a field of a part. shift: it is given in units of 1 << shift bytes.
template <auto Part, auto Field = nullptr, int shift = 0>
struct At {
    template <typename P>
    static auto& in(P& profile) {
        if constexpr (std::is_null_pointer_v<decltype(Field)>)
            return profile.*Part;
        else
            return profile.*Part.*Field;
    }
    static double get(const Profile& profile) {
        if constexpr (shift != 0)
            return static_cast<double>(in(profile) >> shift);
        else
            return static_cast<double>(in(profile));
    }
    static void set(Profile& profile, double value) {
        using T = std::remove_reference_t<decltype(in(profile))>;
        if constexpr (shift != 0)
            in(profile) = static_cast<T>(static_cast<std::uint64_t>(value) << shift);
        else
            in(profile) = static_cast<T>(value);
    }
};

// One key for both methods' vertex buffers: only one of them is made.
struct Vertices {
    static double get(const Profile& p) {
        return p.method == Method::recursive ? p.budget.vertices : p.cut_budget.vertices;
    }
    static void set(Profile& p, double value) {
        p.budget.vertices = p.cut_budget.vertices = static_cast<std::uint32_t>(value);
    }
};

struct Items {
    static double get(const Profile& p) { return p.cut.max_work == unlimited_work ? 0 : p.cut.max_work; }
    static void set(Profile& p, double value) {
        p.cut.max_work = value == 0 ? unlimited_work : static_cast<std::uint32_t>(value);
    }
};

// In the order of the enumerations.
constexpr const char* methods[] = {"incremental", "recursive"};
constexpr const char* morphs[] = {"none", "error", "time"};
constexpr const char* metrics[] = {"isotropic", "depth"};
constexpr const char* topologies[] = {"list", "strip"};
constexpr const char* suns[] = {"direction", "time"};
constexpr const char* airs[] = {"simple", "physical"};
constexpr const char* exposures[] = {"automatic", "fixed"};
constexpr const char* curves[] = {"none", "filmic"};
static_assert(static_cast<int>(Method::recursive) == 1 && static_cast<int>(Morph::error) == 1 &&
                  static_cast<int>(Morph::time) == 2 && static_cast<int>(Metric::depth) == 1 &&
                  static_cast<int>(Topology::strip) == 1 && static_cast<int>(gl::SunBy::time) == 1 &&
                  static_cast<int>(gl::Air::physical) == 1 && static_cast<int>(gl::Exposure::fixed) == 1 &&
                  static_cast<int>(gl::ToneCurve::filmic) == 1,
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

constexpr auto whole_key = KeyKind::whole, flag_key = KeyKind::flag, choice_key = KeyKind::choice;

constexpr ProfileKey keys[] = {
    {.table = "refine",
     .name = "method",
     .label = "Method",
     .kind = choice_key,
     .choices = methods,
     .about = "How the mesh is updated. \"incremental\": the mesh is kept from frame to frame and "
              "refined all around the eye. It costs 100 to 400 ns for each change, and next to nothing "
              "while the camera rests. \"recursive\": the mesh is selected anew in every "
              "frame. It costs 30 to 140 ns for each selected vertex, but selects only the quarter that "
              "is in view.",
     .rebuild = Rebuild::method,
     .get = At<&Profile::method>::get,
     .set = At<&Profile::method>::set},
    {.table = "refine",
     .name = "max_error_px",
     .old_name = "error_px",
     .label = "Threshold",
     .unit = "px",
     .least = ranges::least_threshold_px,
     .most = ranges::most_threshold_px,
     .logarithmic = true,
     .about = "Threshold: the largest error on screen. Pixels, 0.01 to 1000. Halving it takes 2 to 3.5 "
              "times the vertices and the time.",
     .get = At<&Profile::refine, &RefineSettings::max_error_px>::get,
     .set = At<&Profile::refine, &RefineSettings::max_error_px>::set},
    {.table = "refine",
     .name = "corner_safe",
     .label = "Bound in corners",
     .kind = flag_key,
     .about = "Bounds the error in pixels in the image's corners too, not only as an angle: true or "
              "false. It divides the threshold by 1.48 for a picture of 4:3 at 45 degrees, and by 1.71 "
              "for 16:9. That takes 1.7 and 2.1 times the vertices.",
     .get = At<&Profile::refine, &RefineSettings::corner_safe>::get,
     .set = At<&Profile::refine, &RefineSettings::corner_safe>::set},
    {.table = "refine",
     .name = "hysteresis",
     .label = "Hysteresis",
     .most = ranges::max_hysteresis,
     .zero = "none",
     .about = "A vertex becomes active above max_error_px, and inactive below max_error_px / (1 + hysteresis). In "
              "between it stays as it is; an update that evaluates it anyway activates it in the upper half. No unit, "
              "0 to 10. 0.04 takes 4% more vertices; while the camera is slow, an update takes half of the time or "
              "less. 0.3 takes a third more vertices. (Incremental.)",
     .used_by = UsedBy::incremental,
     .get = At<&Profile::cut, &CutSettings::hysteresis>::get,
     .set = At<&Profile::cut, &CutSettings::hysteresis>::set},
    {.table = "refine",
     .name = "offscreen_factor",
     .label = "Off-screen",
     .least = 1,
     .most = max_offscreen_factor,
     .logarithmic = true,
     .about = "Ground that no view sees, nor soon will, is refined to max_error_px times this. No unit, "
              "1 to 100. With 1 all ground is refined alike, and turning changes no vertex. 8 takes 0.3 to 0.8 of the "
              "vertices, and 0.3 to 0.5 of the time of a flight straight on. Turning then refines the "
              "ground that comes into sight, and an export is coarse outside the views. (Incremental.)",
     .used_by = UsedBy::incremental,
     .get = At<&Profile::cut, &CutSettings::offscreen_factor>::get,
     .set = At<&Profile::cut, &CutSettings::offscreen_factor>::set},
    {.table = "refine",
     .name = "morph",
     .label = "Morph",
     .kind = choice_key,
     .most = 2,
     .choices = morphs,
     .about = "How vertices appear and disappear. \"none\": at once. \"error\": they morph with the "
              "distance, which takes a sixth more vertices. \"time\": they morph over morph_s "
              "seconds, and the threshold holds only after a vertex has finished. (Incremental.)",
     .used_by = UsedBy::incremental,
     .get = At<&Profile::cut, &CutSettings::morph>::get,
     .set = At<&Profile::cut, &CutSettings::morph>::set},
    {.table = "refine",
     .name = "morph_s",
     .label = "Morph time",
     .unit = "s",
     .least = ranges::min_morph_s,
     .most = ranges::max_morph_s,
     .logarithmic = true,
     .about = "Time that a vertex activated late takes to morph. Seconds, 0.01 to 10. Costs a write and an upload of "
              "28 bytes for each such vertex. (Incremental.)",
     .used_by = UsedBy::incremental,
     .get = At<&Profile::cut, &CutSettings::morph_s>::get,
     .set = At<&Profile::cut, &CutSettings::morph_s>::set},
    {.table = "refine",
     .name = "metric",
     .label = "Metric",
     .kind = choice_key,
     .choices = metrics,
     .about = "The distance by which errors are divided: \"isotropic\", the distance to the eye, or "
              "\"depth\", the distance along the view (thesis 5.4.1; needs cull = true). With depth the "
              "bound is kept in the image's corners too if the view is level, for a tenth more "
              "vertices. (Recursive.)",
     .used_by = UsedBy::recursive,
     .get = At<&Profile::refine, &RefineSettings::metric>::get,
     .set = At<&Profile::refine, &RefineSettings::metric>::set},
    {.table = "refine",
     .name = "cull",
     .label = "Cull to the view",
     .kind = flag_key,
     .about = "Leaves out vertices outside the view frustum: true or false. False refines all around, "
              "for about four times the vertices at 45 degrees, and the mesh does not change when the "
              "camera turns. (Recursive. The incremental method refines all around, and draws the tiles "
              "that may be seen.)",
     .used_by = UsedBy::recursive,
     .get = At<&Profile::refine, &RefineSettings::cull>::get,
     .set = At<&Profile::refine, &RefineSettings::cull>::set},
    {.table = "refine",
     .name = "topology",
     .label = "Topology",
     .kind = choice_key,
     .choices = topologies,
     .about = "\"list\": an indexed triangle list, three indices a triangle. \"strip\": one strip a tile, as in the "
              "thesis, about 0.6 of the indices. (Recursive.)",
     .used_by = UsedBy::recursive,
     .get = At<&Profile::refine, &RefineSettings::topology>::get,
     .set = At<&Profile::refine, &RefineSettings::topology>::set},

    {.table = "budget",
     .name = "vertices",
     .label = "Vertices",
     .kind = whole_key,
     .unit = "vertices",
     .least = ranges::min_budget,
     .most = ranges::max_vertices,
     .logarithmic = true,
     .about = "Slots of the vertex buffer. Vertices, 16 to 134217728. Incremental: 57 bytes each, 28 on "
              "the GPU, and 19.7 KB of page state for each 64 vertices, up to the number of pages. "
              "Recursive: 20 bytes each, 12 on the GPU, and a quarter to a sixth as many suffice. When "
              "they do not suffice, the threshold rises, the mesh stays crack-free, and the report says "
              "\"vertices\".",
     .rebuild = Rebuild::method,
     .get = Vertices::get,
     .set = Vertices::set},
    {.table = "budget",
     .name = "triangles",
     .label = "Triangles",
     .kind = whole_key,
     .unit = "triangles",
     .least = ranges::min_budget,
     .most = ranges::max_triangles,
     .logarithmic = true,
     .about = "Slots of the index buffer. Triangles, 16 to 536870912. 12 bytes each, on the GPU too. "
              "The mesh has about two for each active vertex, and up to an eighth of the slots is idle "
              "in half-full segments. When they do not suffice, the threshold rises and the report says "
              "\"triangles\". (Incremental.)",
     .rebuild = Rebuild::method,
     .used_by = UsedBy::incremental,
     .get = At<&Profile::cut_budget, &CutBudget::triangles>::get,
     .set = At<&Profile::cut_budget, &CutBudget::triangles>::set},
    {.table = "budget",
     .name = "views",
     .label = "Views",
     .kind = whole_key,
     .unit = "views",
     .least = 1,
     .most = max_cut_views,
     .about = "Views that share one mesh, as for split screen and shadows. Views, 1 to 8. They take "
              "hardly any memory. Each one adds its distances to every evaluation. fjell-fly has one "
              "view. (Incremental.)",
     .rebuild = Rebuild::method,
     .used_by = UsedBy::incremental,
     .get = At<&Profile::cut_budget, &CutBudget::views>::get,
     .set = At<&Profile::cut_budget, &CutBudget::views>::set},
    {.table = "budget",
     .name = "workers",
     .label = "Building threads",
     .kind = whole_key,
     .least = 1,
     .most = max_cut_workers,
     .about = "Threads that build the mesh in the first frame and after a jump, the calling thread "
              "included. 1 to 64. 160 KB each with tiles of 513. The mesh is the same with any number. "
              "(Incremental.)",
     .rebuild = Rebuild::method,
     .used_by = UsedBy::incremental,
     .get = At<&Profile::cut_budget, &CutBudget::workers>::get,
     .set = At<&Profile::cut_budget, &CutBudget::workers>::set},
    {.table = "budget",
     .name = "max_work",
     .old_name = "items",
     .label = "Work items per frame",
     .kind = whole_key,
     .unit = "items",
     .most = ranges::most_work,
     .logarithmic = true,
     .zero = "no limit",
     .about = "Work that a frame may do: groups evaluated, vertices activated or deactivated. Items, 0 "
              "to 4294967294; 0: no limit. An item takes 100 to 400 ns, depending on the cache. "
              "When they do not suffice, the mesh lags behind the camera and the report says \"items\". "
              "(Incremental.)",
     .used_by = UsedBy::incremental,
     .get = Items::get,
     .set = Items::set},
    {.table = "budget",
     .name = "max_time_us",
     .old_name = "budget_us",
     .label = "Update time",
     .unit = "us",
     .most = ranges::most_time_us,
     .logarithmic = true,
     .zero = "no limit",
     .about = "Time that an update may take. Microseconds, 0 to 1000000; 0: no limit. The clock is "
              "read every few items, so an update exceeds it by at most some microseconds. With a limit "
              "of time no two runs are alike. When it does not suffice, the report says \"time\". "
              "(Incremental.)",
     .used_by = UsedBy::incremental,
     .get = At<&Profile::cut, &CutSettings::max_time_us>::get,
     .set = At<&Profile::cut, &CutSettings::max_time_us>::set},
    {.table = "budget",
     .name = "indices",
     .label = "Indices",
     .kind = whole_key,
     .unit = "indices",
     .least = ranges::min_budget,
     .most = ranges::max_indices,
     .logarithmic = true,
     .about = "Indices of one frame. Indices, 16 to 1073741824. 4 bytes each, and as many on the GPU. "
              "All of them are uploaded in every frame. A list needs about 6 for each selected vertex, "
              "strips 3.5. When they do not suffice, the report says \"indices\". (Recursive.)",
     .rebuild = Rebuild::method,
     .used_by = UsedBy::recursive,
     .get = At<&Profile::budget, &RecursiveBudget::indices>::get,
     .set = At<&Profile::budget, &RecursiveBudget::indices>::set},

    {.table = "stream",
     .name = "page_slots",
     .label = "Page slots",
     .kind = whole_key,
     .unit = "pages",
     .least = 1,
     .most = ranges::max_page_slots,
     .logarithmic = true,
     .about = "Pages in memory at a time. Pages, 1 to 16777216, and at least one for each tile of the "
              "pack. 12.5 KB each. When they do not suffice, the terrain is coarser where its error "
              "shows least, and the report says \"page_slots\".",
     .rebuild = Rebuild::session,
     .used_by = UsedBy::streaming,
     .get = At<&Profile::page_slots>::get,
     .set = At<&Profile::page_slots>::set},
    {.table = "stream",
     .name = "page_requests",
     .label = "Page requests",
     .kind = whole_key,
     .unit = "pages",
     .least = 1,
     .most = ranges::max_page_requests,
     .logarithmic = true,
     .about = "Page requests in flight. Pages, 1 to 256; some 16 KB each. Fewer requests react "
              "faster when the camera turns; more requests keep a disk of high latency busy.",
     .rebuild = Rebuild::session,
     .used_by = UsedBy::streaming,
     .get = At<&Profile::stream_budget, &StreamBudget::page_requests>::get,
     .set = At<&Profile::stream_budget, &StreamBudget::page_requests>::set},
    {.table = "stream",
     .name = "map_requests",
     .label = "Mip requests",
     .kind = whole_key,
     .unit = "mips",
     .least = 1,
     .most = ranges::max_map_requests,
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
     .kind = whole_key,
     .unit = "MB",
     .least = 1,
     .most = ranges::max_map_mb,
     .logarithmic = true,
     .about = "Maps on the GPU. MB (1048576 bytes), 1 to 65536, and at least the smallest size of all "
              "tiles. When they do not suffice, maps are blurrier where it shows least, and the report "
              "says \"map_bytes\".",
     .rebuild = Rebuild::session,
     .used_by = UsedBy::streaming,
     .get = At<&Profile::stream_budget, &StreamBudget::map_bytes, 20>::get,
     .set = At<&Profile::stream_budget, &StreamBudget::map_bytes, 20>::set},
    {.table = "stream",
     .name = "tail_log2",
     .label = "Smallest map size, log2",
     .kind = whole_key,
     .least = ranges::min_tail_log2,
     .most = max_texture_log2,
     .about = "Map size that every tile always has, read before all others. 2 to 12: a power of two of "
              "texels a side. One more takes four times the bytes; 6 takes 2.7 KB of colours and 5.5 KB "
              "of normals for each tile.",
     .rebuild = Rebuild::session,
     .used_by = UsedBy::streaming,
     .get = At<&Profile::stream_budget, &StreamBudget::tail_log2>::get,
     .set = At<&Profile::stream_budget, &StreamBudget::tail_log2>::set},
    {.table = "stream",
     .name = "decoders",
     .label = "Reading threads",
     .kind = whole_key,
     .least = 1,
     .most = ranges::most_decoders,
     .about = "Threads that read and decompress pages and maps, beside the thread of the frame. 1 to "
              "16. One decodes some 400 million samples a second. 160 KB each.",
     .rebuild = Rebuild::session,
     .used_by = UsedBy::streaming,
     .get = At<&Profile::stream_budget, &StreamBudget::decoders>::get,
     .set = At<&Profile::stream_budget, &StreamBudget::decoders>::set},
    {.table = "stream",
     .name = "texel_px",
     .label = "Texel size",
     .unit = "px",
     .least = ranges::min_texel_px,
     .most = ranges::max_texel_px,
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
     .most = ranges::max_lookahead_s,
     .zero = "not at all",
     .about = "How far ahead the camera's motion is predicted. Seconds, 0 to 10; 0: not at all. It "
              "loads pages on the way in advance, and some pages that are never wanted.",
     .used_by = UsedBy::streaming,
     .get = At<&Profile::stream, &StreamSettings::lookahead_s>::get,
     .set = At<&Profile::stream, &StreamSettings::lookahead_s>::set},
    {.table = "stream",
     .name = "fade_s",
     .label = "Fade in",
     .unit = "s",
     .most = ranges::max_fade_s,
     .zero = "at once",
     .about = "Time in which a new mip fades in. Seconds, 0 to 10; 0: at once. Costs nothing.",
     .used_by = UsedBy::streaming,
     .get = At<&Profile::stream, &StreamSettings::fade_s>::get,
     .set = At<&Profile::stream, &StreamSettings::fade_s>::set},
    {.table = "stream",
     .name = "pages",
     .label = "Pages per frame",
     .kind = whole_key,
     .unit = "pages",
     .least = 1,
     .most = ranges::max_stream_pages,
     .logarithmic = true,
     .about = "Pages inserted in a frame. Pages, 1 to 4096; 5 to 10 us each. When they do not suffice, the rest waits "
              "for the next frame, and the report says \"stream_pages\".",
     .used_by = UsedBy::streaming,
     .get = At<&Profile::stream, &StreamSettings::pages>::get,
     .set = At<&Profile::stream, &StreamSettings::pages>::set},
    {.table = "stream",
     .name = "tests",
     .label = "Pages tested per frame",
     .kind = whole_key,
     .unit = "pages",
     .least = ranges::min_stream_tests,
     .most = 0xffffffff,
     .logarithmic = true,
     .about = "Pages that a frame may test to find those that the views want. Pages, 1024 to "
              "4294967295; some 10 ns each. When they do not suffice, the search goes on in the next "
              "frame, and the report says \"stream_tests\".",
     .used_by = UsedBy::streaming,
     .get = At<&Profile::stream, &StreamSettings::tests>::get,
     .set = At<&Profile::stream, &StreamSettings::tests>::set},
    {.table = "stream",
     .name = "map_kb",
     .label = "Map uploads per frame",
     .kind = whole_key,
     .unit = "KB",
     .least = 1,
     .most = ranges::max_map_kb,
     .logarithmic = true,
     .about = "Maps uploaded in a frame, but always at least one mip. KB (1024 bytes), 1 to 1048576. "
              "Too large a value makes single frames long. When more has arrived, the report says "
              "\"stream_upload\".",
     .used_by = UsedBy::streaming,
     .get = At<&Profile::stream, &StreamSettings::map_bytes, 10>::get,
     .set = At<&Profile::stream, &StreamSettings::map_bytes, 10>::set},

    {.table = "view",
     .name = "width_px",
     .label = "Width",
     .kind = whole_key,
     .unit = "px",
     .least = 1,
     .most = ranges::max_size_px,
     .about = "The picture's width. Pixels, 1 to 16384. Drawing costs with the area.",
     .get = At<&Profile::width_px>::get,
     .set = At<&Profile::width_px>::set},
    {.table = "view",
     .name = "height_px",
     .label = "Height",
     .kind = whole_key,
     .unit = "px",
     .least = 1,
     .most = ranges::max_size_px,
     .about = "The picture's height. Pixels, 1 to 16384. At an equal threshold the number of vertices "
              "grows with it. Drawing costs with the area.",
     .get = At<&Profile::height_px>::get,
     .set = At<&Profile::height_px>::set},
    {.table = "view",
     .name = "fov_deg",
     .label = "Field of view",
     .unit = "deg",
     .least = ranges::min_fov_deg,
     .most = ranges::max_fov_deg,
     .about = "Vertical field of view. Degrees, 1 to 150. A narrower one magnifies: 30 instead of 45 takes a quarter "
              "more vertices.",
     .get = At<&Profile::fov_deg>::get,
     .set = At<&Profile::fov_deg>::set},
    {.table = "view",
     .name = "samples",
     .label = "Samples per pixel",
     .kind = whole_key,
     .unit = "samples",
     .least = 1,
     .most = ranges::max_samples,
     .about = "Samples per pixel that smooth edges (MSAA). Samples, 1 to 16, and no more than the GPU "
              "has. 4 take 32 bytes a pixel, and in software nearly twice the time. For pictures and "
              "the window of fjell-fly; the editor's picture has one sample.",
     .get = At<&Profile::samples>::get,
     .set = At<&Profile::samples>::set},

    {.table = "light",
     .name = "sun",
     .label = "Sun position",
     .kind = KeyKind::choice,
     .choices = suns,
     .about = "How the sun is placed. \"direction\": by azimuth_deg and elevation_deg. \"time\": by "
              "year, month, day and hour_utc, seen from latitude_deg and longitude_deg, to 0.02 "
              "degrees.",
     .get = At<&Profile::light, &Light::sun>::get,
     .set = At<&Profile::light, &Light::sun>::set},
    {.table = "light",
     .name = "azimuth_deg",
     .label = "Azimuth",
     .unit = "deg",
     .most = 360,
     .about = "The sun's azimuth, clockwise from north. Degrees, 0 to 360. From the upper left (315) relief looks as "
              "on maps. (By direction.)",
     .get = At<&Profile::light, &Light::azimuth_deg>::get,
     .set = At<&Profile::light, &Light::azimuth_deg>::set},
    {.table = "light",
     .name = "elevation_deg",
     .label = "Elevation",
     .unit = "deg",
     .least = gl::min_sun_elevation_deg,
     .most = 90,
     .about = "The sun's elevation above the horizon. Degrees, -18 to 90. Below 0 the sky alone gives light. (By "
              "direction.)",
     .get = At<&Profile::light, &Light::elevation_deg>::get,
     .set = At<&Profile::light, &Light::elevation_deg>::set},
    {.table = "light",
     .name = "latitude_deg",
     .label = "Latitude",
     .unit = "deg",
     .least = -90,
     .most = 90,
     .about = "Where the terrain lies: latitude, north positive. Degrees, -90 to 90. (By time.)",
     .get = At<&Profile::light, &Light::latitude_deg>::get,
     .set = At<&Profile::light, &Light::latitude_deg>::set},
    {.table = "light",
     .name = "longitude_deg",
     .label = "Longitude",
     .unit = "deg",
     .least = -180,
     .most = 180,
     .about = "Where the terrain lies: longitude, east positive. Degrees, -180 to 180. (By time.)",
     .get = At<&Profile::light, &Light::longitude_deg>::get,
     .set = At<&Profile::light, &Light::longitude_deg>::set},
    {.table = "light",
     .name = "year",
     .label = "Year",
     .kind = KeyKind::whole,
     .least = gl::min_sun_year,
     .most = gl::max_sun_year,
     .about = "Year. Years, 1950 to 2050. (By time.)",
     .get = At<&Profile::light, &Light::year>::get,
     .set = At<&Profile::light, &Light::year>::set},
    {.table = "light",
     .name = "month",
     .label = "Month",
     .kind = KeyKind::whole,
     .least = 1,
     .most = 12,
     .about = "Month. 1 to 12. (By time.)",
     .get = At<&Profile::light, &Light::month>::get,
     .set = At<&Profile::light, &Light::month>::set},
    {.table = "light",
     .name = "day",
     .label = "Day",
     .kind = KeyKind::whole,
     .least = 1,
     .most = 31,
     .about = "Day of the month. 1 to 31. Days after the month's end count on into the next month. (By "
              "time.)",
     .get = At<&Profile::light, &Light::day>::get,
     .set = At<&Profile::light, &Light::day>::set},
    {.table = "light",
     .name = "hour_utc",
     .label = "Hour, UTC",
     .unit = "h",
     .most = 24,
     .about = "Universal time: what a clock in Greenwich shows in winter. Hours, 0 to 24; 17.5 is half past five in "
              "the afternoon. (By time.)",
     .get = At<&Profile::light, &Light::hour_utc>::get,
     .set = At<&Profile::light, &Light::hour_utc>::set},
    {.table = "light",
     .name = "air",
     .label = "Air",
     .kind = KeyKind::choice,
     .choices = airs,
     .about =
         "How the sky and the air before the ground are drawn. \"simple\": two colours of the sky, and haze of one "
         "density. \"physical\": from a table of the sky, bluer with the distance and thinner with the height.",
     .get = At<&Profile::light, &Light::air>::get,
     .set = At<&Profile::light, &Light::air>::set},
    {.table = "light",
     .name = "visibility_km",
     .label = "Visibility",
     .unit = "km",
     .least = gl::min_visibility_km,
     .most = gl::max_visibility_km,
     .logarithmic = true,
     .about = "The distance at which a dark ridge can just be told from the sky at sea level. "
              "Kilometres, 1 to 280: 280 is pure air, 160 a clear day, 20 haze, 5 a dull day. Terrain "
              "of more than 400 km across is treated as a model of that size.",
     .get = At<&Profile::light, &Light::visibility_km>::get,
     .set = At<&Profile::light, &Light::visibility_km>::set},
    {.table = "light",
     .name = "exposure",
     .label = "Exposure",
     .kind = KeyKind::choice,
     .choices = exposures,
     .about = "\"automatic\": by the light that falls on the lowest ground, as an incident-light meter "
              "measures it. It does not depend on the view, so pictures of one sun match. \"fixed\": by "
              "ev100.",
     .get = At<&Profile::light, &Light::exposure>::get,
     .set = At<&Profile::light, &Light::exposure>::set},
    {.table = "light",
     .name = "ev100",
     .label = "Exposure value",
     .unit = "EV",
     .least = gl::min_ev100,
     .most = gl::max_ev100,
     .about =
         "Exposure value at ISO 100. Stops, -6 to 20: 15 for ground in the sun, 12 at sunrise, 6 at dusk. (Fixed.)",
     .get = At<&Profile::light, &Light::ev100>::get,
     .set = At<&Profile::light, &Light::ev100>::set},
    {.table = "light",
     .name = "exposure_bias_ev",
     .label = "Exposure bias",
     .unit = "EV",
     .least = -gl::max_exposure_bias_ev,
     .most = gl::max_exposure_bias_ev,
     .about = "Makes the picture brighter by so many stops, with automatic and with fixed exposure. "
              "Stops, -8 to 8.",
     .get = At<&Profile::light, &Light::exposure_bias_ev>::get,
     .set = At<&Profile::light, &Light::exposure_bias_ev>::set},
    {.table = "light",
     .name = "tone_curve",
     .label = "Tone curve",
     .kind = KeyKind::choice,
     .choices = curves,
     .about = "How light becomes a picture. \"none\": in proportion, cut off at white. \"filmic\": it rolls off "
              "towards white, as film does.",
     .get = At<&Profile::light, &Light::tone_curve>::get,
     .set = At<&Profile::light, &Light::tone_curve>::set},
    {.table = "light",
     .name = "dither",
     .label = "Dither",
     .kind = KeyKind::flag,
     .about = "Noise of half an 8-bit step, so that skies show no bands: true or false.",
     .get = At<&Profile::light, &Light::dither>::get,
     .set = At<&Profile::light, &Light::dither>::set},
    {.table = "light",
     .name = "detail",
     .label = "Detail",
     .kind = KeyKind::flag,
     .about = "Fine noise on ground so near that a texel of its map covers many pixels: true or false. 6 to 12 texture "
              "reads a pixel.",
     .get = At<&Profile::light, &Light::detail>::get,
     .set = At<&Profile::light, &Light::detail>::set},
    {.table = "light",
     .name = "shadows",
     .label = "Shadows",
     .kind = KeyKind::flag,
     .about = "Shadows of the ground, and less light where the ground hides some of the sky: true or "
              "false. Needs a pack baked with --horizons. The horizon maps take room among the maps on "
              "the GPU. Shading takes six more texture reads a pixel.",
     .rebuild = Rebuild::session,
     .get = At<&Profile::light, &Light::shadows>::get,
     .set = At<&Profile::light, &Light::shadows>::set},
    {.table = "light",
     .name = "water",
     .label = "Water",
     .kind = KeyKind::flag,
     .about = "A sheet of water at water_level_m over the ground that lies below it: true or false.",
     .get = At<&Profile::light, &Light::water>::get,
     .set = At<&Profile::light, &Light::water>::set},
    {.table = "light",
     .name = "water_level_m",
     .label = "Water level",
     .unit = "m",
     .least = gl::min_water_level_m,
     .most = gl::max_water_level_m,
     .about = "Height of the water, as the terrain's heights are counted. Metres, -12000 to 100000.",
     .get = At<&Profile::light, &Light::water_level_m>::get,
     .set = At<&Profile::light, &Light::water_level_m>::set},

    {.table = "layers",
     .name = "on",
     .label = "Detail layers",
     .kind = KeyKind::flag,
     .about = "Materials on near ground, from fjell-fly --materials and --layers: true or false. "
              "Without such files none are drawn. Some 10 to 20 texture reads a pixel, only on near "
              "ground.",
     .get = At<&Profile::layers, &Layers::on>::get,
     .set = At<&Profile::layers, &Layers::on>::set},
    {.table = "layers",
     .name = "splat",
     .old_name = "control",
     .label = "Splat maps",
     .kind = KeyKind::flag,
     .about = "Takes the places of materials from a pack's splat maps, which fjell-bake --layers makes: "
              "true or false. They take room among the maps on the GPU. Drawing takes 4 to 8 more "
              "texture reads a pixel. Without them the rules of fjell-fly --layers place the materials.",
     .rebuild = Rebuild::session,
     .get = At<&Profile::layers, &Layers::splat>::get,
     .set = At<&Profile::layers, &Layers::splat>::set},
    {.table = "layers",
     .name = "distance_m",
     .label = "Drawn up to",
     .unit = "m",
     .least = gl::min_layer_distance_m,
     .most = gl::max_layer_distance_m,
     .logarithmic = true,
     .about = "The distance beyond which the ground has only its map's colour. Metres, 1 to 100000. "
              "Materials begin to fade at 0.4 of it. Pixels beyond it cost next to nothing on a GPU; in "
              "software a far view takes 1.2 times as long.",
     .get = At<&Profile::layers, &Layers::distance_m>::get,
     .set = At<&Profile::layers, &Layers::distance_m>::set},
    {.table = "layers",
     .name = "tint",
     .label = "Tint",
     .about = "How far a material takes on the colour of the map under it. 0 to 1: at 0 it keeps its "
              "own colour, at 1 near and far ground have one colour.",
     .get = At<&Profile::layers, &Layers::tint>::get,
     .set = At<&Profile::layers, &Layers::tint>::set},
    {.table = "layers",
     .name = "relief",
     .label = "Relief",
     .most = gl::max_layer_relief,
     .about = "How strongly a material's bumps catch the light. 0 to 4; 1 is their true relief.",
     .get = At<&Profile::layers, &Layers::relief>::get,
     .set = At<&Profile::layers, &Layers::relief>::set},
    {.table = "layers",
     .name = "material_mb",
     .label = "Material textures",
     .kind = KeyKind::whole,
     .unit = "MB",
     .least = 1,
     .most = ranges::max_material_mb,
     .logarithmic = true,
     .about = "GPU memory for the textures of materials. MB, 1 to 65536. Their finest mips are left out "
              "until they fit. Ten materials of 512 texels a side take 7 MB.",
     .rebuild = Rebuild::method,
     .get = At<&Profile::material_bytes, nullptr, 20>::get,
     .set = At<&Profile::material_bytes, nullptr, 20>::set},
};

} // namespace

std::span<const ProfileKey> profile_keys() {
    return keys;
}

std::span<const ProfileTable> profile_tables() {
    return tables;
}

const ProfileKey* find_profile_key(std::string_view dotted) {
    const std::size_t dot = dotted.find('.');
    if (dot == std::string_view::npos) return nullptr;
    const std::string_view table = dotted.substr(0, dot), name = dotted.substr(dot + 1);
    for (const ProfileKey& key : profile_keys())
        if (table == key.table && (name == key.name || (key.old_name && name == key.old_name))) return &key;
    return nullptr;
}

std::vector<const ProfileKey*> differing_keys(const Profile& a, const Profile& b) {
    std::vector<const ProfileKey*> differing;
    for (const ProfileKey& key : profile_keys())
        if (key.get(a) != key.get(b)) differing.push_back(&key);
    return differing;
}

} // namespace fjell
