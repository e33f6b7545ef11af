// What a GPU takes for our pictures (./dev gpu): flights over some scenes at some sizes with several settings of light
// and material, and the same ground drawn as CDLOD's patches (gpu_patches.h). Headless, through EGL, on whatever device
// there is; with timer queries where they tell the truth.
//   gpu_flights PLAN OUT    PLAN: JSON as gpu.sh writes it; OUT: a folder, for gpu.json and pictures
// Every frame is updated, uploaded, drawn and waited for (glFinish). Times are of all frames after the first two.
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <epoxy/gl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "bench/gpu_patches.h"
#include "bench/gpu_times.h"
#include "fjell/gl/context.h"
#include "fjell/gl/image.h"
#include "fjell/io/failure.h"
#include "io/file.h"
#include "session/pictures.h"
#include "session/session.h"
#include "support/times.h"

namespace {

using namespace fjell;
using namespace fjell::session;
using fjell::bench::GpuTimer;
using nlohmann::json;
using test::rank;

constexpr std::size_t warm_frames = 2;
constexpr std::size_t frames_on_gpu = 120, frames_in_software = 3;

struct Setting {
    const char* name;
    bool lit, detail, dither, shadows, water, layers;
    gl::Air air;
};
// Each adds to the one before it, but for the first two.
constexpr Setting settings[] = {
    {"bare colours", false, false, false, false, false, false, gl::Air::simple},
    {"simple air", true, false, false, false, false, false, gl::Air::simple},
    {"physical air", true, false, true, false, false, false, gl::Air::physical},
    {"and shadows", true, false, true, true, false, false, gl::Air::physical},
    {"and detail", true, true, true, true, false, false, gl::Air::physical}, // what profiles have
    {"and water", true, true, true, true, true, false, gl::Air::physical},
    {"and materials", true, true, true, true, true, true, gl::Air::physical},
};
constexpr std::size_t usual = 4; // of them: whose update and upload are told

struct Flown {
    std::vector<double> update_us, upload_us, upload_gpu_us, draw_gpu_us, frame_ms, bytes;
    double triangles = 0, vertices = 0;
    bench::Calls upload_calls, draw_calls; // of the last frame
};

class Scene {
public:
    Scene(const json& plan, const json& scene) : name_(scene.at("name")) {
        options_.pack = scene.at("pack");
        options_.path = scene.at("path");
        options_.streaming = Streaming::off;
        Profile& profile = options_.profile = read_profile(plan.at("profile"));
        profile.fov_deg = scene.at("fov_deg");
        profile.samples = 1;
        profile.light.azimuth_deg = scene.at("azimuth_deg");
        profile.light.elevation_deg = scene.at("elevation_deg");
        profile.light.shadows = true; // horizon maps are loaded
        options_.layers = std::make_shared<GroundLayers>(read_ground_layers(plan.at("materials"), scene.at("rules")));
        open_session(options_, session_);
        const PackHeader& header = session_.terrain().header();
        // Over the lowest tenth of the heights.
        profile.light.water_level_m = 0.9 * static_cast<double>(header.min_m) + 0.1 * static_cast<double>(header.max_m);
        renderer_ = make_renderer(options_, session_);
        poses_ = resample(path_of(options_), session_.ground(), default_frames);
    }
    [[nodiscard]] const std::string& name() const { return name_; }
    [[nodiscard]] std::uint64_t texture_bytes() const { return renderer_->stats().texture_bytes; }

    // The first frames of the path.
    Flown fly(const Setting& setting, std::uint32_t width, std::uint32_t height, std::size_t frames, bool timers,
              const std::string& picture) {
        Profile profile = options_.profile;
        profile.width_px = width;
        profile.height_px = height;
        profile.light.air = setting.air;
        profile.light.detail = setting.detail;
        profile.light.dither = setting.dither;
        profile.light.shadows = setting.shadows;
        profile.light.water = setting.water;
        profile.layers.on = setting.layers;
        const auto target = make_target(width, height, profile);
        const GpuTimer upload, draw;
        session_.begun = false;
        Flown flown;
        for (std::size_t i = 0; i < warm_frames + frames; ++i) {
            io::check_interrupt();
            const double now_s = static_cast<double>(i) / 60;
            const View view = view_of(poses_[std::min(i, poses_.size() - 1)], session_.terrain(), profile);
            gl::DrawOptions drawing = draw_options(PictureMode::shaded, profile, now_s);
            drawing.lit = setting.lit;
            const auto start = test::Clock::now();
            const FrameEntry entry = update_frame(session_, view, profile, now_s);
            (void)bench::take_calls();
            upload.begin();
            upload_mesh(*renderer_, session_, entry);
            upload.end();
            const bench::Calls upload_calls = bench::take_calls();
            draw.begin();
            renderer_->draw_uploaded(session_.mesh(), view, drawing, *target);
            draw.end();
            glFinish();
            const double frame_ms = test::us_since(start) * 1e-3;
            if (i < warm_frames) continue; // shaders are compiled, the whole mesh is uploaded
            flown.upload_calls = upload_calls;
            flown.draw_calls = bench::take_calls();
            flown.frame_ms.push_back(frame_ms);
            flown.update_us.push_back(entry.update_us);
            flown.upload_us.push_back(renderer_->stats().upload_us);
            flown.bytes.push_back(static_cast<double>(renderer_->stats().bytes_uploaded));
            flown.triangles += renderer_->stats().triangles / static_cast<double>(frames);
            flown.vertices += entry.vertices / static_cast<double>(frames);
            if (!timers) continue;
            flown.upload_gpu_us.push_back(upload.us());
            flown.draw_gpu_us.push_back(draw.us());
        }
        if (!picture.empty()) {
            gl::Image image;
            target->read_colour(image);
            gl::write_png(image, picture);
        }
        return flown;
    }

private:
    std::string name_;
    FlightOptions options_;
    Session session_;
    std::unique_ptr<gl::Renderer> renderer_;
    std::vector<Pose> poses_;
};

json spread(const std::vector<double>& values) { // null: not measured
    if (values.empty()) return {};
    return {{"p50", rank(values, 0.5)}, {"p99", rank(values, 0.99)}};
}
json told(const bench::Calls& calls) {
    return {{"calls", calls.calls}, {"draws", calls.draws}, {"dispatches", calls.dispatches}};
}

// A software renderer takes seconds for a large picture.
std::uint32_t pixels(const json& plan, const json& asked) {
    const std::uint32_t of_gpu = asked;
    return bench::in_software() ? of_gpu / plan.at("smaller_in_software").get<std::uint32_t>() : of_gpu;
}

json fly_scene(const json& plan, const json& place, std::size_t frames, bool timers, const std::string& out) {
    json rows = json::array();
    Scene scene(plan, place);
    for (const auto& size : plan.at("sizes"))
        for (const Setting& setting : settings) {
            const std::uint32_t width = pixels(plan, size.at(0)), height = pixels(plan, size.at(1));
            const auto number = &setting - settings;
            const std::string picture = fmt::format("{}-{}-{}.png", scene.name(), width, number);
            const Flown flown = scene.fly(setting, width, height, frames, timers, out + "/" + picture);
            rows.push_back({{"scene", scene.name()},
                            {"width", width},
                            {"height", height},
                            {"setting", setting.name},
                            {"usual", number == usual},
                            {"vertices", flown.vertices},
                            {"triangles", flown.triangles},
                            {"update_us", spread(flown.update_us)},
                            {"upload_us", spread(flown.upload_us)},
                            {"upload_gpu_us", spread(flown.upload_gpu_us)},
                            {"draw_gpu_us", spread(flown.draw_gpu_us)},
                            {"frame_ms", spread(flown.frame_ms)},
                            {"uploaded_bytes", spread(flown.bytes)},
                            {"texture_bytes", scene.texture_bytes()},
                            {"upload", told(flown.upload_calls)},
                            {"draw", told(flown.draw_calls)},
                            {"picture", picture}});
            fmt::print(stderr, "{}, {} x {}, {}: {:.2f} ms a frame\n", scene.name(), width, height, setting.name,
                       rank(flown.frame_ms, 0.5));
        }
    return rows;
}

bench::PatchPlan patch_plan(const json& plan, bool timers, const std::string& out) {
    const json& p = plan.at("patches");
    bench::PatchPlan result;
    result.one_tile = p.at("one_tile");
    result.tiles = p.at("tiles");
    result.width = pixels(plan, p.at("size").at(0));
    result.height = pixels(plan, p.at("size").at(1));
    result.error_px = p.at("error_px");
    result.triangles = p.at("triangles").get<std::vector<std::uint32_t>>();
    result.repeats = timers ? 50 : 3;
    result.timers = timers;
    result.out = out;
    return result;
}

int run(int argc, char** argv) {
    if (argc != 3) throw io::Failure(2, "usage: gpu_flights PLAN OUT; see tests/bench/gpu.sh");
    io::catch_interrupts();
    const std::string out = argv[2];
    std::filesystem::create_directories(out);
    const json plan = json::parse(io::read_text(argv[1]));
    const auto context = gl::Headless::create();
    const bool timers = bench::timers_are_real();
    const std::size_t frames = timers ? frames_on_gpu : frames_in_software;
    bench::count_calls();
    json result{{"device", gl::describe_current()},
                {"software", bench::in_software()},
                {"timers", timers},
                {"date", fmt::format("{:%F}", fmt::gmtime(std::time(nullptr)))},
                {"terrain", plan.at("terrain")},
                {"frames", frames},
                {"flights", json::array()}};
    for (const json& place : plan.at("scenes"))
        for (json& row : fly_scene(plan, place, frames, timers, out)) result["flights"].push_back(std::move(row));
    result["patches"] = bench::draw_patches(patch_plan(plan, timers, out));
    if (const GLenum error = glGetError(); error != GL_NO_ERROR)
        throw io::Failure(3, fmt::format("OpenGL has found an error, {:#x}: the figures are not to be trusted", error));
    const std::string text = result.dump(2) + "\n";
    io::AtomicFile file(out + "/gpu.json");
    file.write(std::as_bytes(std::span(text)));
    file.commit();
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return io::run_tool("gpu_flights", [&] { return run(argc, argv); });
}
