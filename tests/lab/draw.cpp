#include "lab/draw.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <limits>

#include <epoxy/gl.h>
#include <fmt/format.h>

#include "fjell/cut.h"
#include "fjell/io/failure.h"
#include "fjell/recursive.h"
#include "support/times.h"

namespace fjell::lab {

namespace {

constexpr std::uint32_t picture_width_px = 640, picture_height_px = 480;
constexpr double finest_px = 0.01;

void need(const Status& status) {
    if (!status.ok()) throw io::Failure(1, fmt::format("{}: {}", status.field, message(status.code)));
}
// Of all threads: a software renderer has several.
double process_worked_ms() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

gl::DrawOptions bare() {
    gl::DrawOptions options;
    options.lit = options.haze = options.sky = false;
    return options;
}

} // namespace

// update() finds a view's mesh from the one before, rest() as it is when the view stands.
struct Drawing::Method {
    io::AlignedMemory memory;
    double effective_px = 0;
    std::uint32_t vertices = 0, triangles = 0; // of the last mesh
    virtual ~Method() = default;
    virtual void update(const View& view) = 0;
    virtual void rest(const View& view) = 0;
    virtual void draw(gl::Renderer& renderer, const View& view, const gl::DrawOptions& options,
                      const gl::Target& target) = 0;
};

namespace {

// What both report alike.
template <typename Method, typename Report>
void note(Method& method, const Report& report) {
    method.effective_px = report.error_bound_px;
    method.vertices = report.vertices;
    method.triangles = report.triangles;
}

} // namespace

std::unique_ptr<Drawing::Method> Drawing::recursive(double error_px) {
    struct Recursive final : Method {
        RecursiveMethod method;
        RefineSettings settings;
        FrameReport report;
        void update(const View& view) override {
            need(update_recursive(method, view, settings, report));
            note(*this, report);
        }
        void rest(const View& view) override { update(view); }
        void draw(gl::Renderer& renderer, const View& view, const gl::DrawOptions& options,
                  const gl::Target& target) override {
            renderer.draw(recursive_mesh(method), view, options, target);
        }
    };
    auto made = std::make_unique<Recursive>();
    const RecursiveBudget budget{vertices_, 6 * vertices_};
    const std::size_t bytes = recursive_bytes(pack_.terrain, budget);
    made->memory = io::allocate(bytes);
    made->settings.max_error_px = error_px;
    need(create_recursive(pack_.terrain, budget, {made->memory.get(), bytes}, made->method));
    return made;
}

std::unique_ptr<Drawing::Method> Drawing::incremental(double error_px, double offscreen_factor) {
    struct Incremental final : Method {
        LiveCut cut;
        CutSettings settings;
        CutReport report;
        void update(const View& view) override {
            need(update_cut(cut, {&view, 1}, settings, report));
            note(*this, report);
        }
        void rest(const View& view) override {
            need(rebuild_cut(cut, {&view, 1}, settings, report));
            update(view);
        }
        void draw(gl::Renderer& renderer, const View& view, const gl::DrawOptions& options,
                  const gl::Target& target) override {
            renderer.draw(cut_mesh(cut), cut_take_changes(cut), view, options, target);
        }
    };
    auto made = std::make_unique<Incremental>();
    const CutBudget budget{vertices_, 2 * vertices_ + 1024 * pack_.terrain.tile_count(), 512, 1};
    const std::size_t bytes = cut_bytes(pack_.terrain, budget);
    made->memory = io::allocate(bytes);
    made->settings.max_error_px = error_px;
    made->settings.offscreen_factor = offscreen_factor;
    need(create_cut(pack_.terrain, budget, {made->memory.get(), bytes}, made->cut));
    return made;
}

std::unique_ptr<Drawing> Drawing::create(const io::LoadedPack& pack, std::uint32_t vertices, std::string& reason) {
    std::unique_ptr<Drawing> drawing(new Drawing(pack, vertices));
    const std::uint32_t triangles = 2 * vertices + 1024 * pack.terrain.tile_count();
    gl::RendererOptions options{vertices, 3 * triangles};
    options.ranges = triangles / 512;
    options.morph = true; // the live cut's meshes need it
    try {
        drawing->context_ = gl::Headless::create();
        drawing->target_ = gl::Target::create({picture_width_px, picture_height_px, 1});
        drawing->renderer_ = gl::Renderer::create(pack.terrain, pack.pack, options);
    } catch (const io::Failure& failure) {
        reason = failure.what();
        return nullptr;
    }
    return drawing;
}

const gl::Image& Drawing::picture(Method& method, const View& view) {
    gl::DrawOptions options;
    options.light.dither = false;
    method.draw(*renderer_, view, options, *target_);
    target_->read_colour(image_);
    return image_;
}

const Drawing::Finest& Drawing::finest(std::size_t frame, const View& view) {
    const auto at = finest_.find(frame);
    if (at != finest_.end()) return at->second;
    const auto method = recursive(finest_px);
    method->rest(view);
    Finest made{picture(*method, view), {}, method->effective_px};
    std::vector<float> depth;
    target_->read_depth(depth);
    for (const float d : depth) made.covered.push_back(d > 0);
    return finest_.emplace(frame, std::move(made)).first->second;
}

nlohmann::json Drawing::fly(const Case& c, const std::vector<View>& views, const std::set<std::size_t>& timed,
                            const std::set<std::size_t>& compared) {
    if (!context_->make_current()) throw io::Failure(3, "the OpenGL context cannot be made current; run it again");
    const auto method = c.way == Way::recursive ? recursive(c.error_px) : incremental(c.error_px, c.offscreen_factor);
    method->rest(views[0]);
    const gl::DrawOptions options = bare();
    for (int i = 0; i < 2; ++i) method->draw(*renderer_, views[0], options, *target_); // uploads all
    glFinish();
    std::vector<double> ms, worked_ms;
    double vertices = 0, triangles = 0, worst_px = 0;
    for (const std::size_t frame : timed) {
        io::check_interrupt();
        const View& view = views[frame];
        method->rest(views[frame > 0 ? frame - 1 : 0]);
        method->draw(*renderer_, views[frame > 0 ? frame - 1 : 0], options, *target_);
        glFinish();
        const auto start = test::Clock::now();
        const double worked = process_worked_ms();
        method->update(view);
        method->draw(*renderer_, view, options, *target_);
        glFinish();
        worked_ms.push_back(process_worked_ms() - worked);
        ms.push_back(test::us_since(start) * 1e-3);
        vertices += method->vertices / static_cast<double>(timed.size());
        triangles += method->triangles / static_cast<double>(timed.size());
        worst_px = std::max(worst_px, method->effective_px);
    }
    if (worst_px > c.error_px)
        throw io::Failure(1, fmt::format("at {} px a budget does not suffice; ask for a larger threshold", c.error_px));
    nlohmann::json all{{"vertices", vertices},
                       {"triangles", triangles},
                       {"frame_ms", test::rank(ms, 0.5)},
                       {"frame_work_ms", test::rank(worked_ms, 0.5)},
                       {"frames_a_second", 1e3 / test::rank(ms, 0.5)}};
    double mean = 0, psnr = std::numeric_limits<double>::max(), reference = 0;
    for (const std::size_t frame : compared) {
        io::check_interrupt();
        const Finest& best = finest(frame, views[frame]);
        method->rest(views[frame]);
        const Difference d = difference_of(picture(*method, views[frame]), best.image, best.covered);
        mean += d.mean / static_cast<double>(compared.size());
        if (d.mean > 0) psnr = std::min(psnr, d.psnr_db);
        reference = std::max(reference, best.error_px);
    }
    if (compared.empty()) return all;
    all["image_difference"] = mean;
    all["finest_px"] = reference;
    if (mean > 0) all["psnr_db"] = psnr;
    return all;
}

Difference difference_of(const gl::Image& a, const gl::Image& b, const std::vector<bool>& covered) {
    double sum = 0, squares = 0, count = 0;
    for (std::size_t i = 0; i < a.rgb.size(); ++i) {
        if (!covered[i / 3]) continue;
        const double d = std::abs(int{a.rgb[i]} - int{b.rgb[i]});
        sum += d;
        squares += d * d;
        ++count;
    }
    if (count == 0) return {};
    return {sum / count,
            squares > 0 ? 10 * std::log10(255.0 * 255.0 * count / squares) : std::numeric_limits<double>::infinity()};
}

} // namespace fjell::lab
