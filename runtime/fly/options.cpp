#include "fly/options.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string_view>
#include <utility>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "fjell/gltf/snapshot.h"
#include "fjell/io/failure.h"
#include "fjell/io/journal.h"
#include "fjell/io/pack_file.h"
#include "fjell/pack.h"
#include "fjell/profile/keys.h"
#include "io/command_line.h"
#include "io/file.h"
#include "io/system.h"
#include "session/methods/method.h"
#include "session/path.h"
#include "session/pictures.h"

namespace fjell::session {

namespace {

using io::Failure;

constexpr std::size_t most_frames = 10'000'000;

// Flags as they were typed; empty where they were not, so that the profile can stand.
struct Flags {
    std::optional<double> error_px, fov_deg, budget_us, hysteresis, offscreen_factor;
    std::optional<std::uint32_t> items;
    std::string method, morph, metric, topology, cull, size, mode = "shaded", stream = "auto";
    bool corner_safe = false;
    std::vector<std::string> exports, light;
    std::optional<std::uint32_t> samples;
    std::optional<std::uint64_t> seed;
    std::string eye, look;
};

void declare_flight(CLI::App& app, FlightOptions& o, Flags& f) {
    app.add_option("PACK", o.pack, "the terrain, from fjell-bake: a pack, or the folder of a pack set")->required();
    app.add_option("--profile", o.profile_path, "budgets and thresholds (profiles/*.toml); flags override it");
    app.add_option("--path", o.path, "camera path (content/paths/*.json); default: an orbit");
    app.add_option("--frames", o.frames, "frames to resample the path to (default 840); a window closes after them")
        ->check(io::whole_within(1, most_frames));
    app.add_option("--hz", o.hz, "path frames a second, in the window and for morphing (default 60)")
        ->check(io::within(0.1, 10000));
    app.add_option("--seed", f.seed, "fly a random path with this seed instead of --path");
    app.add_option("--eye", f.eye,
                   "X,Y,Z: a still camera there instead of a path; metres east, up and south of sample "
                   "(0, 0)");
    app.add_option("--look", f.look, "X,Y,Z: the point that --eye looks at");
    app.add_flag("--headless", o.headless, "no window");
    app.add_option("--error-px", f.error_px, "threshold: largest error on screen, in pixels")
        ->check(io::within(ranges::least_threshold_px, ranges::most_threshold_px));
    app.add_option("--method", f.method,
                   "incremental (default): keep the mesh from frame to frame; recursive: select it anew in every frame")
        ->check(io::one_of({"incremental", "recursive"}));
    app.add_flag("--corner-safe", f.corner_safe, "bound the error in pixels in the image's corners too");
    app.add_option("--fov", f.fov_deg, "vertical field of view in degrees")
        ->check(io::within(ranges::min_fov_deg, ranges::max_fov_deg));
    app.add_option("--size", f.size, "picture in pixels, WIDTHxHEIGHT");
}

void declare_edits(CLI::App& app, FlightOptions& o) {
    auto* const edits =
        app.add_option("--edits", o.edits_path,
                       "stamps that move the ground, each in its frame (content/edits/*.json), or a journal; default: "
                       "PACK.journal where it lies beside the pack; none: the ground as it was baked");
    app.add_option_function<std::uint32_t>(
           "--edit-blocks",
           [&o](std::uint32_t blocks) {
               o.edit_budget.blocks = blocks;
               o.edit_room = false;
           },
           "blocks of 32 x 32 samples, 4.2 KB each, that --edits may change (default: as many as it needs)")
        ->check(io::whole_within(1, 1u << 24))
        ->needs(edits);
}

void declare_light(CLI::App& app, FlightOptions& o, Flags& f) {
    auto* const materials =
        app.add_option("--materials", o.materials_path, "textures of near ground: a file of fjell-bake materials");
    app.add_option("--layers", o.rules_path,
                   "rules that place the materials, if the pack has no splat maps (content/materials/rules/*.json)")
        ->needs(materials);
    app.add_option("--light", f.light,
                   "KEY=VALUE[,KEY=VALUE]: sun, air, exposure, water: any key of [light] of a profile, as in "
                   "elevation_deg=5,water=true; may be repeated")
        ->allow_extra_args(false);
    app.add_option("--samples", f.samples, "samples per pixel that smooth edges, no more than the GPU has")
        ->check(io::whole_within(1, ranges::max_samples));
}

void declare_methods(CLI::App& app, FlightOptions& o, Flags& f) {
    const char* const incremental = "Incremental method";
    app.add_option("--items", f.items, "work items that a frame may take at most; 0 (default): no limit")
        ->check(io::whole_within(0, ranges::most_work))
        ->group(incremental);
    app.add_option("--budget-us", f.budget_us, "microseconds that an update may take at most; 0 (default): no limit")
        ->check(io::within(0, ranges::most_time_us))
        ->group(incremental);
    app.add_option("--hysteresis", f.hysteresis,
                   "a vertex stays active down to error-px / (1 + this); 0 (default) to 10; 0.04 makes updates cheaper")
        ->check(io::within(0, ranges::max_hysteresis))
        ->group(incremental);
    app.add_option("--offscreen-factor", f.offscreen_factor,
                   "ground that no view sees, nor soon will, is refined to error-px times this; 1 (default) to 100")
        ->check(io::within(1, max_offscreen_factor))
        ->group(incremental);
    app.add_option("--morph", f.morph,
                   "vertices appear at once (none, default), or morph with the distance (error) or over a time (time)")
        ->check(io::one_of({"none", "error", "time"}))
        ->group(incremental);
    app.add_option("--record", o.record, "write the flight to a file that --replay repeats bit for bit")
        ->group(incremental);
    app.add_option("--replay", o.replay, "repeat a recording of this pack instead of flying a path")
        ->group(incremental);
    const char* const recursive = "Recursive method";
    app.add_option("--metric", f.metric, "distance to the eye (isotropic, default) or depth along the view")
        ->check(io::one_of({"isotropic", "depth"}))
        ->group(recursive);
    app.add_option("--topology", f.topology, "triangle list (default), or one strip a tile")
        ->check(io::one_of({"list", "strip"}))
        ->group(recursive);
    app.add_option("--cull", f.cull,
                   "on (default): refine only inside the frustum; off: all around, as the incremental method does")
        ->check(io::one_of({"on", "off"}))
        ->group(recursive);
}

void declare_streaming(CLI::App& app, FlightOptions& o, Flags& f) {
    const char* const group = "Streaming";
    app.add_option("--stream", f.stream,
                   "read pages and maps when the views want them; auto (default): when the pack has more pages than "
                   "[stream] page_slots of the profile")
        ->check(io::one_of({"on", "off", "auto"}))
        ->group(group);
    app.add_flag(
           "--wait", o.wait,
           "headless: every frame waits until all pages that its view wants are loaded; by default only drawn and "
           "exported frames wait")
        ->group(group);
    app.add_flag("--realtime", o.realtime, "headless: one frame every 1/hz seconds, as in a window; no frame waits")
        ->group(group);
    app.add_option("--read-mb-s", o.read_mb_s,
                   "read no faster than this, to imitate a slower disk; 0 (default): no limit")
        ->check(io::within(0, 1e6))
        ->group(group);
    app.add_option("--read-latency-ms", o.read_latency_ms,
                   "wait before every read, to imitate a slower disk; 0 (default): no wait")
        ->check(io::within(0, 10000))
        ->group(group);
    app.add_flag("--cold", o.cold, "ask the system to drop its cache of the pack before the flight")->group(group);
}

void declare_outputs(CLI::App& app, FlightOptions& o, Flags& f) {
    app.add_option("--csv", o.csv, "one line a frame; - for standard output");
    app.add_option("--json", o.json, "a summary for scripts; - for standard output");
    app.add_option("--export", f.exports, "FRAME:OUT.glb, the mesh as that frame draws it; may be repeated")
        ->allow_extra_args(false);
    app.add_flag("--export-converged", o.export_converged,
                 "--export the converged mesh of the frame's view, as if time and items were unlimited");
    app.add_option("--export-texel", o.export_texel_m,
                   "width of a texel of --export's textures in metres; 0 (default): as fine as the maps are")
        ->check(io::within(0, 1e6));
    app.add_flag("--export-quantised", o.export_quantised,
                 "--export with 16 bits a number (KHR_mesh_quantization); the file says what the rounding moves");
    app.add_flag("--export-meshopt", o.export_meshopt,
                 "--export compressed (EXT_meshopt_compression), which not all viewers read");
    app.add_option_function<std::string>(
           "--export-texture", [&o](const std::string& word) { o.export_jpeg = word == "jpeg"; },
           "how --export writes colours: png (default) loses nothing, jpeg is smaller; normals and occlusion are PNG")
        ->check(io::one_of({"png", "jpeg"}));
    app.add_option("--render", o.render_folder, "write frame_NNNNN.png into this folder, which is created if need be");
    app.add_option("--render-every", o.render_every, "only every N-th frame")->check(io::whole_within(1, most_frames));
    app.add_option("--mode", f.mode,
                   "what pictures show: light and colours (shaded, default), edges too (wire), or a colour for each "
                   "tree level, tile, mip, loaded step of geometry (residency) or distance")
        ->check(io::one_of(std::vector<std::string>(std::begin(picture_mode_names), std::end(picture_mode_names))));
    app.add_option(
           "--verify", o.verify_every,
           "every N frames, measure the error at every sample; of a streamed pack this loads a second, whole copy")
        ->check(io::whole_within(1, most_frames));
}

// A whole number that fills the text, or nothing.
std::optional<std::size_t> whole(std::string_view text) {
    std::size_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) return {};
    return value;
}

void parse_size(const std::string& text, Profile& profile) {
    const std::size_t x = std::min(text.find('x'), text.size());
    const auto width = whole(std::string_view(text).substr(0, x));
    const auto height = whole(std::string_view(text).substr(std::min(x + 1, text.size())));
    if (!width || !height || *width < 1 || *height < 1 || *width > ranges::max_size_px || *height > ranges::max_size_px)
        throw Failure(
            2, fmt::format("--size {}: must be WIDTHxHEIGHT in pixels, 1 to {} each", text, ranges::max_size_px));
    profile.width_px = static_cast<std::uint32_t>(*width);
    profile.height_px = static_cast<std::uint32_t>(*height);
}

Vec3 parse_place(const char* flag, const std::string& text) {
    double at[3] = {};
    const char* next = text.data();
    const char* const end = next + text.size();
    bool fits = true;
    for (int axis = 0; axis < 3 && fits; ++axis) {
        if (axis != 0) fits = next != end && *next++ == ',';
        const auto [after, error] = std::from_chars(next, end, at[axis]);
        fits = fits && error == std::errc() && std::abs(at[axis]) <= 1e8;
        next = after;
    }
    if (!fits || next != end)
        throw Failure(2, fmt::format("{} {}: must be X,Y,Z in metres, e.g. {} 1000,2500,-300", flag, text, flag));
    return {at[0], at[1], at[2]};
}

// Every part is one key of [light], in the words of its table.
void parse_light(std::string_view text, Profile& profile) {
    while (!text.empty()) {
        const std::string_view part = text.substr(0, text.find(','));
        text.remove_prefix(std::min(part.size() + 1, text.size()));
        const std::size_t equals = part.find('=');
        const ProfileKey* const key =
            equals == part.npos ? nullptr : find_profile_key(fmt::format("light.{}", part.substr(0, equals)));
        if (!key) {
            std::string names;
            for (const ProfileKey& known : profile_keys())
                if (std::string_view(known.table) == "light")
                    names += (names.empty() ? "" : ", ") + std::string(known.name);
            throw Failure(2, fmt::format("--light {}: must be KEY=VALUE, with one of the keys {}", part, names));
        }
        double value = 0;
        const std::string error = parse_value(*key, part.substr(equals + 1), value);
        if (!error.empty()) throw Failure(2, fmt::format("--light {}: {}", part, error));
        key->set(profile, value);
    }
}

Export parse_export(const std::string& text, std::size_t frames) {
    const std::size_t colon = std::min(text.find(':'), text.size());
    const auto frame = whole(std::string_view(text).substr(0, colon));
    if (!frame || colon + 1 >= text.size())
        throw Failure(2, fmt::format("--export {}: must be FRAME:OUT.glb, e.g. 0:terrain.glb", text));
    if (!gltf::is_snapshot_name(text.substr(colon + 1)))
        throw Failure(2, fmt::format("--export {}: a snapshot is binary glTF; give it a name that ends in .glb", text));
    if (*frame >= frames) throw Failure(2, fmt::format("--export {}: the flight has frames 0 to {}", text, frames - 1));
    return {*frame, text.substr(colon + 1)};
}

void apply(const Flags& f, FlightOptions& o) {
    RefineSettings& refine = o.profile.refine;
    CutSettings& cut = o.profile.cut;
    for (const Method method : {Method::incremental, Method::recursive})
        if (f.method == facts_of(method).name) o.profile.method = method;
    if (f.items) cut.max_work = *f.items ? *f.items : unlimited_work;
    if (f.budget_us) cut.max_time_us = *f.budget_us;
    o.limited = f.items.value_or(0) != 0 || f.budget_us.value_or(0) > 0;
    if (f.hysteresis) cut.hysteresis = *f.hysteresis;
    if (f.offscreen_factor) cut.offscreen_factor = *f.offscreen_factor;
    if (!f.morph.empty()) cut.morph = f.morph == "error" ? Morph::error : f.morph == "time" ? Morph::time : Morph::none;
    if (f.error_px) refine.max_error_px = *f.error_px;
    if (f.fov_deg) o.profile.fov_deg = *f.fov_deg;
    if (!f.metric.empty()) refine.metric = f.metric == "depth" ? Metric::depth : Metric::isotropic;
    if (!f.topology.empty()) refine.topology = f.topology == "strip" ? Topology::strip : Topology::triangles;
    if (!f.cull.empty()) refine.cull = f.cull == "on";
    if (f.corner_safe) refine.corner_safe = true;
    o.streaming = f.stream == "on" ? Streaming::on : f.stream == "off" ? Streaming::off : Streaming::automatic;
    if (!f.size.empty()) parse_size(f.size, o.profile);
    if (f.samples) o.profile.samples = *f.samples;
    for (const std::string& text : f.light) parse_light(text, o.profile);
    if (o.wait) o.profile.stream.fade_s = o.profile.stream.lookahead_s = 0; // time stands still, nothing lies ahead
    for (int i = 0; i < picture_modes; ++i)
        if (f.mode == picture_mode_names[i]) o.mode = static_cast<PictureMode>(i);
    o.seeded = f.seed.has_value();
    o.seed = f.seed.value_or(0);
    if (f.eye.empty() != f.look.empty()) throw Failure(2, "--eye and --look go together; give both");
    if (!f.eye.empty()) o.still = StillCamera{parse_place("--eye", f.eye), parse_place("--look", f.look)};
    for (const std::string& text : f.exports)
        o.exports.push_back(parse_export(text, o.frames ? o.frames : default_frames));
}

// What the chosen method does not do is refused; what it does anyway may be said.
void check_method(const Flags& f, const Profile& profile) {
    const auto needs = [&](bool given, const char* flag, Method method, const char* why) {
        if (given && profile.method != method)
            throw Failure(2, fmt::format("{} needs --method {}: {}", flag, facts_of(method).name, why));
    };
    constexpr Method incremental = Method::incremental, recursive = Method::recursive;
    needs(f.metric == "depth", "--metric depth", recursive, "the incremental method refines all around the eye");
    needs(f.topology == "strip", "--topology strip", recursive, "the incremental method edits triangle lists");
    needs(f.cull == "on", "--cull on", recursive,
          "the incremental method refines all around and draws the tiles that may be seen");
    const char* const anew = "the recursive method finds the whole mesh anew";
    needs(f.items.has_value(), "--items", incremental, anew);
    needs(f.budget_us.has_value(), "--budget-us", incremental, anew);
    needs(f.hysteresis.has_value(), "--hysteresis", incremental, anew);
    needs(f.offscreen_factor.has_value(), "--offscreen-factor", incremental, "the recursive method has --cull");
    needs(!f.morph.empty(), "--morph", incremental, anew);
    if (!facts_of(profile).keeps_mesh && profile.refine.metric == Metric::depth && !profile.refine.cull)
        throw Failure(2, "--metric depth needs --cull on: behind the eye there is no depth");
}

// A replay is as it was recorded: what would be something else is refused, not passed over.
void check_replay(const Flags& f) {
    if (f.error_px || f.fov_deg || f.budget_us || f.hysteresis || f.offscreen_factor || f.items || !f.morph.empty() ||
        !f.size.empty() || f.corner_safe)
        throw Failure(2, "--replay repeats a flight as it was: leave out --error-px, --corner-safe, --fov, --size, "
                         "--items, --budget-us, --hysteresis, --offscreen-factor, --morph");
}

// Pictures of --render that would replace more than a picture of an earlier flight: those that would be called like one
// of the other files, and links that bear a picture's name.
std::vector<std::string> pictures_in(const std::string& folder, const std::vector<std::string>& others) {
    namespace fs = std::filesystem;
    std::vector<std::string> pictures;
    if (folder.empty()) return pictures;
    for (const std::string& other : others)
        if (const std::string name = fs::path(other).filename().string(); is_picture_name(name))
            pictures.push_back(folder + "/" + name);
    std::error_code error, ignored; // what is wrong with the folder is said when it is opened
    for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
        const std::string name = at->path().filename().string();
        if (is_picture_name(name) && (at->is_symlink(ignored) || at->hard_link_count(ignored) != 1))
            pictures.push_back(folder + "/" + name);
    }
    return pictures;
}

void check_together(const FlightOptions& o) {
    if (o.seeded && !o.path.empty()) throw Failure(2, "--seed and --path exclude each other; give one of them");
    if (o.still && (o.seeded || !o.path.empty()))
        throw Failure(2, "--eye is a camera of its own: leave out --seed and --path");
    if (o.export_converged && o.exports.empty()) throw Failure(2, "--export-converged needs --export FRAME:OUT.glb");
    for (const auto& [given, name] :
         {std::pair{o.export_texel_m > 0, "texel"}, std::pair{o.export_quantised, "quantised"},
          std::pair{o.export_meshopt, "meshopt"}, std::pair{o.export_jpeg, "texture"}})
        if (given && o.exports.empty()) throw Failure(2, fmt::format("--export-{} needs --export FRAME:OUT.glb", name));
    if (!o.headless && !o.render_folder.empty()) throw Failure(2, "--render needs --headless");
    if (!o.headless && !o.exports.empty()) throw Failure(2, "--export needs --headless");
    if (!o.headless && o.wait) throw Failure(2, "--wait needs --headless: a window never waits");
    if (!o.headless && o.realtime) throw Failure(2, "--realtime needs --headless: a window always keeps real time");
    if (o.wait && o.realtime) throw Failure(2, "--wait and --realtime exclude each other; give one of them");
    if (o.streaming == Streaming::off && (o.cold || o.read_mb_s > 0 || o.read_latency_ms > 0))
        throw Failure(2,
                      "--cold, --read-mb-s and --read-latency-ms apply to streaming, and --stream off streams nothing: "
                      "leave them out, or give --stream on");
    if (o.render_folder.empty() && o.render_every != 1) throw Failure(2, "--render-every needs --render DIR");
    if (o.csv == "-" && o.json == "-")
        throw Failure(2, "--csv - and --json - would mix on standard output; give one of them a file");
    if (!o.record.empty() && !facts_of(o.profile).keeps_mesh)
        throw Failure(2, "--record needs --method incremental: the recursive method keeps nothing to repeat");
    if (!o.replay.empty()) {
        if (!o.headless) throw Failure(2, "--replay needs --headless");
        if (!o.path.empty() || o.seeded || o.still || o.frames || !o.record.empty() || !o.exports.empty() ||
            !o.edits_path.empty())
            throw Failure(2, "--replay repeats a flight as it was: leave out --path, --seed, --eye, --frames, "
                             "--edits, --record, --export");
        if (o.streaming == Streaming::on || o.wait || o.cold || o.read_mb_s > 0 || o.read_latency_ms > 0)
            throw Failure(2, "--replay repeats the page arrivals that were recorded and streams nothing: leave out "
                             "--stream, --wait, --cold, --read-mb-s, --read-latency-ms");
        if (!facts_of(o.profile).keeps_mesh)
            throw Failure(2, "--replay needs --method incremental: that is what was recorded");
    }
    std::vector<std::string> outputs{o.csv, o.json, o.record};
    for (const Export& e : o.exports) outputs.push_back(e.path);
    const std::vector<std::string> inputs{o.pack,       o.path,   o.profile_path, o.materials_path,
                                          o.rules_path, o.replay, o.edits_path};
    io::refuse_overwriting(outputs, inputs);
    std::vector<std::string> others = outputs;
    others.insert(others.end(), inputs.begin(), inputs.end());
    outputs.emplace_back();
    for (const std::string& picture : pictures_in(o.render_folder, others)) {
        outputs.back() = picture;
        io::refuse_overwriting(outputs, inputs);
    }
}

// Without --edits the pack's own journal, as the editor opens it. A replay has the stamps that were recorded, and the
// packs of a shard take none.
void find_journal(FlightOptions& o) {
    if (o.edits_path == "none") return o.edits_path.clear();
    if (!o.edits_path.empty() || !o.replay.empty()) return;
    const std::string path = io::journal_path(o.pack);
    io::os::FileInfo there;
    if (!io::os::look(path, there)) return;
    const PackHeader header = io::PackFile(o.pack).pack().header;
    if (header.tiles_held != 0) return;
    try {
        const io::Journal journal(path, header, io::JournalAccess::read);
        const std::size_t stamps = journal.stamps().size();
        if (stamps == 0) return;
        fmt::print(stderr, "fjell-fly: {}: {} stamps of it change the ground; --edits none leaves them out\n", path,
                   stamps);
        o.edits_path = path;
    } catch (const Failure& failure) { // nobody has named it
        fmt::print(stderr, "fjell-fly: flies without its journal: {}\n", failure.what());
    }
}

// A flight in a window goes on until it is closed, unless its frames are given.
void read_edits(FlightOptions& o) {
    o.stamps = io::is_journal(o.edits_path) ? io::read_stamps(o.edits_path, &io::PackFile(o.pack).pack().header)
                                            : io::read_stamps(o.edits_path);
    if (o.stamps.empty()) return;
    const std::size_t frames = o.frames ? o.frames : default_frames;
    if ((o.headless || o.frames) && o.stamps.back().frame >= frames)
        throw Failure(1, fmt::format("{}: a stamp is pushed in frame {}, and the flight has frames 0 to {}; raise "
                                     "--frames, or lower its \"frame\"",
                                     o.edits_path, o.stamps.back().frame, frames - 1));
}

} // namespace

bool parse_options(int argc, char** argv, FlightOptions& options) {
    Flags flags;
    CLI::App app{"Flies a camera over a Fjell pack, in a window or --headless.", "fjell-fly"};
    app.set_version_flag("--version", fmt::format("fjell-fly, pack version {}", pack_version));
    declare_flight(app, options, flags);
    declare_edits(app, options);
    declare_light(app, options, flags);
    declare_methods(app, options, flags);
    declare_streaming(app, options, flags);
    declare_outputs(app, options, flags);
    if (!io::parse_command_line(app, argc, argv, "fjell-fly")) return false;
    if (!options.profile_path.empty()) {
        std::vector<std::string> renamed;
        options.profile = read_profile(options.profile_path, &renamed);
        for (const std::string& line : renamed) fmt::print(stderr, "fjell-fly: {}\n", line);
    }
    apply(flags, options);
    check_method(flags, options.profile);
    if (!options.replay.empty()) check_replay(flags);
    find_journal(options);
    check_together(options);
    if (!options.edits_path.empty()) read_edits(options);
    if (!options.materials_path.empty())
        options.layers =
            std::make_shared<const GroundLayers>(read_ground_layers(options.materials_path, options.rules_path));
    return true;
}

} // namespace fjell::session
