#include "editor/jobs/threshold_search.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "editor/number_text.h"
#include "fjell/io/failure.h"
#include "fjell/profile.h"
#include "session/log.h"

namespace fjell::editor {

namespace {

constexpr double doubtful = 0.9;   // of the budget: what takes less has no business beside one that fails
constexpr double hopeless = 1.5;   // of the budget, for half of all frames: not flown again
constexpr double resolved = 1.015; // thresholds that lie no farther apart are not told apart
constexpr std::uint32_t most_at_one = 3;

// A threshold and the least that each frame took in its flights, with the parts of that.
struct Candidate {
    TunePoint point;
    std::vector<double> least_us;
    std::vector<CostParts> least_parts_us;
};

void keep_least(Candidate& c, const FlightCost& flight) {
    const bool parted = !flight.parts_us.empty();
    for (std::size_t i = 0; i < c.least_us.size(); ++i) {
        if (flight.times_us[i] >= c.least_us[i]) continue;
        c.least_us[i] = flight.times_us[i];
        if (parted) c.least_parts_us[i] = flight.parts_us[i];
    }
}

CostParts mean_from(double least_us, const Candidate& c) {
    CostParts mean{};
    double count = 0;
    for (std::size_t i = 0; i < c.least_parts_us.size(); ++i) {
        if (c.least_us[i] < least_us) continue;
        for (std::size_t k = 0; k < mean.size(); ++k) mean[k] += c.least_parts_us[i][k];
        ++count;
    }
    for (double& us : mean) us /= std::max(count, 1.0);
    return mean;
}

class Search {
public:
    Search(const TuneSettings& settings, const std::function<FlightCost(double)>& fly,
           const std::function<void(const TuneResult&)>& each)
        : settings_(settings), fly_(fly), each_(each) {}

    TuneResult run();

private:
    Candidate& candidate(double error_px);
    void add(Candidate& c, FlightCost flight) const;
    void fly(Candidate& c);
    bool settle(Candidate& c);
    bool keeps(double error_px) { return settle(candidate(error_px)); }
    bool reconsider(double error_px);
    void descend();
    void bisect();
    void recall(Candidate& c, Candidate before) const;
    bool confirm();
    void publish();
    [[nodiscard]] std::uint32_t expected() const;
    [[nodiscard]] bool may_fly() const { return result_.flights < most_flights; }

    const TuneSettings& settings_;
    const std::function<FlightCost(double)>& fly_;
    const std::function<void(const TuneResult&)>& each_;
    std::vector<Candidate> candidates_; // by falling threshold
    double good_px_ = 0, bad_px_ = 0;   // the ends of what is left: keeps, and does not; 0: none known
    bool confirming_ = false;
    TuneResult result_;
};

Candidate& Search::candidate(double error_px) {
    const auto at = std::ranges::find_if(candidates_, [&](const Candidate& c) { return c.point.error_px <= error_px; });
    if (at != candidates_.end() && at->point.error_px == error_px) return *at;
    Candidate fresh;
    fresh.point.error_px = error_px;
    return *candidates_.insert(at, std::move(fresh));
}

void Search::add(Candidate& c, FlightCost flight) const {
    TunePoint& p = c.point;
    if (p.flights == 0) {
        c.least_us = std::move(flight.times_us);
        c.least_parts_us = std::move(flight.parts_us);
    } else {
        keep_least(c, flight);
    }
    p.reached = p.flights == 0 ? flight.reached : std::max(p.reached, flight.reached);
    p.vertices = flight.vertices;
    p.frames = static_cast<std::uint32_t>(c.least_us.size());
    ++p.flights;
    const session::Percentiles times = session::percentiles(c.least_us);
    p.p50_us = times.p50;
    p.p99_us = times.p99;
    p.max_us = times.max;
    p.dearest_us = mean_from(times.p99, c);
    p.keeps = p.p99_us <= settings_.budget_us && p.reached >= least_reached;
}

void Search::fly(Candidate& c) {
    add(c, fly_(c.point.error_px));
    ++result_.flights;
    publish();
}

void Search::publish() {
    result_.curve.clear();
    for (const Candidate& c : candidates_)
        if (c.point.flights != 0) result_.curve.push_back(c.point);
    result_.expected = std::max(expected(), result_.flights);
    each_(result_);
}

// About two flights a step near the limit, and one above it.
std::uint32_t Search::expected() const {
    if (confirming_) return result_.flights + 1;
    double more = 2;
    if (bad_px_ == 0) {
        const double from_px = good_px_ > 0 ? good_px_ : settings_.most_px;
        more += (1 + std::log2(from_px / settings_.least_px)) / 2 + 12;
    } else {
        more += 2 * std::max(std::log2(std::log(good_px_ / bad_px_) / std::log(resolved)), 0.0);
    }
    return std::min(result_.flights + static_cast<std::uint32_t>(more), most_flights);
}

// Whether it keeps the budget, after as few flights as say so. Half of all frames is more than other programs spoil,
// but for what they take of the caches.
bool Search::settle(Candidate& c) {
    const TunePoint& p = c.point;
    while (!p.keeps && p.flights < most_at_one && may_fly()) {
        fly(c);
        if (p.p50_us > hopeless * settings_.budget_us || p.reached < least_reached) break;
    }
    return p.keeps;
}

// Two more flights for one that failed; true when it keeps the budget after all.
bool Search::reconsider(double error_px) {
    Candidate& c = candidate(error_px);
    for (int i = 0; i < 2 && !c.point.keeps && may_fly(); ++i) fly(c);
    return c.point.keeps;
}

// By halves, until one fails or least_px keeps the budget too.
void Search::descend() {
    const double least = rounded_up(settings_.least_px);
    while (good_px_ > least && bad_px_ == 0) {
        const double next = std::max(rounded_up(good_px_ / 2), least);
        (keeps(next) ? good_px_ : bad_px_) = next;
    }
}

void Search::bisect() {
    while (good_px_ / bad_px_ > resolved && may_fly()) {
        const double next = rounded_up(std::sqrt(good_px_ * bad_px_));
        if (next >= good_px_ || next <= bad_px_) return;
        (keeps(next) ? good_px_ : bad_px_) = next;
    }
}

// Once it has been judged anew, the flights before count as well: often each of them was the only one.
void Search::recall(Candidate& c, Candidate before) const {
    const std::uint32_t flights = c.point.flights + before.point.flights;
    add(c, {std::move(before.least_us), before.point.vertices, before.point.reached, std::move(before.least_parts_us)});
    c.point.flights = flights;
}

// What was found is flown again. Where it fails, what lies between it and the next larger one that kept the budget is
// searched again: false.
bool Search::confirm() {
    confirming_ = true;
    Candidate& found = candidate(good_px_);
    Candidate before = std::exchange(found, {});
    found.point.error_px = good_px_;
    if (settle(found)) {
        recall(found, std::move(before));
        return true;
    }
    if (found.point.flights == 0) found = before; // no flight is left to doubt it with
    if (found.point.keeps) return true;
    for (auto c = candidates_.rbegin(); c != candidates_.rend(); ++c)
        if (c->point.error_px > good_px_ && c->point.keeps) {
            bad_px_ = good_px_;
            good_px_ = c->point.error_px;
            bisect();
            return false;
        }
    good_px_ = 0;
    return true;
}

TuneResult Search::run() {
    const double most = rounded_up(settings_.most_px);
    if (keeps(most)) {
        good_px_ = most;
        for (int round = 0; round < 2; ++round) {
            bad_px_ = 0;
            descend();
            if (bad_px_ == 0) break;
            bisect();
            const TunePoint good = candidate(good_px_).point, bad = candidate(bad_px_).point;
            // Beside a limit that is not time's, the neighbour has room to spare by right.
            const bool odd = good.p99_us < doubtful * settings_.budget_us && bad.reached >= least_reached;
            if (round != 0 || !odd || !reconsider(bad_px_)) break;
            good_px_ = bad_px_;
        }
        while (!confirm()) {
        }
    }
    confirming_ = true;
    result_.best_px = good_px_;
    publish();
    return std::move(result_);
}

// In the order of CostParts.
constexpr const char* cost_parts[] = {"preparing views", "refining",  "writing triangles",
                                      "streaming",       "uploading", "drawing"};
static_assert(std::size(cost_parts) == std::tuple_size_v<CostParts>, "a part was added: name it");

// limits: time does, and not the range or a budget of the profile.
std::string limit_of(const TunePoint& p, bool limits) {
    const LimitingPart part = limiting_part(p.dearest_us);
    if (part.name == nullptr) return "";
    if (limits)
        return fmt::format(", limited by {} ({:.0f}% of the slowest frames' time)", part.name, 100 * part.share);
    return fmt::format(", mostly for {} ({:.0f}% of the slowest frames' time)", part.name, 100 * part.share);
}

std::string what_helps(const TunePoint& p, const TuneSettings& s) {
    if (p.reached < least_reached)
        return fmt::format("{:.0f}% of the frames reached it: raise vertices, triangles, work items or page slots",
                           100 * p.reached);
    return fmt::format("p99 {} ms of {} ms{}: {}", fine_ms_text(p.p99_us).text, fine_ms_text(s.budget_us).text,
                       limit_of(p, true),
                       s.measure == TuneMeasure::frame ? "choose a smaller picture, or a larger budget"
                                                       : "choose a slower path, fewer work items, or a larger budget");
}

} // namespace

const TunePoint* TuneResult::at(double error_px) const {
    const auto found = std::ranges::find(curve, error_px, &TunePoint::error_px);
    return found == curve.end() ? nullptr : &*found;
}

LimitingPart limiting_part(const CostParts& parts_us) {
    const auto most = std::ranges::max_element(parts_us);
    const double sum = std::accumulate(parts_us.begin(), parts_us.end(), 0.0);
    if (!(sum > 0)) return {};
    return {cost_parts[static_cast<std::size_t>(most - parts_us.begin())], *most / sum};
}

double rounded_up(double error_px) {
    const double unit = std::pow(10.0, std::floor(std::log10(error_px)) - 2);
    // A hair less, or 1.23 would become 1.24: it is 123.00000000000001 hundredths.
    const double digits = std::ceil(error_px / unit - 1e-9);
    return unit < 1 ? digits / std::round(1 / unit) : digits * unit; // the double that "1.23" reads as
}

TuneResult find_threshold(const TuneSettings& settings, const std::function<FlightCost(double)>& fly,
                          const std::function<void(const TuneResult&)>& each) {
    return Search(settings, fly, each).run();
}

std::string tune_text(const TuneResult& result, const TuneSettings& settings, const std::string& flight) {
    if (result.curve.empty()) return "no flight was made";
    if (result.best_px == 0)
        return fmt::format("no threshold up to {:.3g} px keeps the budget over {}; there {}; {} flights",
                           result.curve.front().error_px, flight, what_helps(result.curve.front(), settings),
                           result.flights);
    const TunePoint* const best = result.at(result.best_px);
    const bool least = result.best_px == rounded_up(settings.least_px);
    std::string why;
    for (const TunePoint& p : result.curve) // what the next smaller one lacked, where it was not time
        if (p.error_px < result.best_px) {
            if (p.reached < least_reached) why = "; below it a budget of the profile is the limit, not time";
            break;
        }
    return fmt::format("{:.3g} px{} over {}: p99 {} ms of {} ms{}{}; {} flights", result.best_px,
                       least ? ", the smallest allowed," : "", flight, fine_ms_text(best->p99_us).text,
                       fine_ms_text(settings.budget_us).text, limit_of(*best, !least && why.empty()), why,
                       result.flights);
}

std::string tune_csv(const std::vector<TunePoint>& curve) {
    std::string text = "threshold_px,p50_us,p99_us,max_us,vertices,frames,keeps,reached,flights\n";
    for (const TunePoint& p : curve)
        text += fmt::format("{},{:.3f},{:.3f},{:.3f},{:.1f},{},{},{:.4f},{}\n", p.error_px, p.p50_us, p.p99_us,
                            p.max_us, p.vertices, p.frames, p.keeps ? 1 : 0, p.reached, p.flights);
    return text;
}

void check(const TuneSettings& s) {
    if (!(s.budget_us >= 10 && s.budget_us <= 1e6))
        throw io::Failure(
            2, fmt::format("the budget (budget_us) is {} us: must be 10 to 1,000,000 us, which is 0.01 to 1,000 ms",
                           s.budget_us));
    if (s.frames != 0 && (s.frames < 10 || s.frames > 100'000))
        throw io::Failure(2, fmt::format("frames {}: must be 10 to 100,000, or 0 for the path's own", s.frames));
    if (!(s.least_px >= ranges::least_threshold_px && s.least_px < s.most_px && s.most_px <= ranges::most_threshold_px))
        throw io::Failure(2, fmt::format("least_px {} and most_px {}: must rise, from {} to {} pixels", s.least_px,
                                         s.most_px, ranges::least_threshold_px, ranges::most_threshold_px));
}

} // namespace fjell::editor
