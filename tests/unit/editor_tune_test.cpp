// How the tuner looks for a threshold, over costs that are made up: a curve, noise on it, and frames that other
// programs spoil.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "editor/jobs/threshold_search.h"
#include "fjell/io/failure.h"

using namespace fjell::editor;

namespace {

// Frames cost scale / error_px^power microseconds, each its own share of it, up to 1.
struct Cost {
    double scale = 2000, power = 1.5;
    double noise = 0;        // the dearer part of any frame, evenly up to this share of it
    double spoiled = 0;      // share of frames that take four times as long
    double reached_from = 0; // thresholds below are not reached
    std::uint32_t seed = 1;
    std::uint32_t frames = 400;

    [[nodiscard]] double p99_us(double error_px) const { return scale / std::pow(error_px, power) * 0.99; }
    // The threshold whose p99 is exactly that.
    [[nodiscard]] double threshold(double budget_us) const { return std::pow(scale * 0.99 / budget_us, 1 / power); }
};

struct Tuned {
    TuneResult result;
    std::vector<double> flown; // in their order
    std::vector<TuneResult> published;
};

Tuned tune(const Cost& cost, const TuneSettings& settings) {
    std::mt19937 random(cost.seed);
    std::uniform_real_distribution<double> share(0, 1);
    Tuned t;
    const auto fly = [&](double error_px) {
        t.flown.push_back(error_px);
        FlightCost flight;
        flight.reached = error_px >= cost.reached_from ? 1 : 0.5;
        flight.vertices = 1e5 / error_px;
        for (std::uint32_t i = 1; i <= cost.frames; ++i) {
            double us = cost.scale / std::pow(error_px, cost.power) * i / cost.frames;
            us *= 1 + cost.noise * share(random);
            if (share(random) < cost.spoiled) us *= 4;
            flight.times_us.push_back(us);
        }
        return flight;
    };
    t.result = find_threshold(settings, fly, [&](const TuneResult& r) { t.published.push_back(r); });
    return t;
}

TuneSettings asked(double budget_us) {
    TuneSettings s;
    s.budget_us = budget_us;
    return s;
}

} // namespace

TEST_CASE("the tuner finds the smallest threshold that keeps the budget, to two in a hundred, in a few flights") {
    for (const double power : {0.7, 1.0, 1.5, 2.0})
        for (const double budget_us : {300.0, 1000.0, 2000.0, 7000.0}) {
            Cost cost;
            cost.power = power;
            const Tuned t = tune(cost, asked(budget_us));
            const double right = std::max(cost.threshold(budget_us), asked(budget_us).least_px);
            INFO("power " << power << ", budget " << budget_us << ": found " << t.result.best_px << ", is " << right);
            CHECK(cost.p99_us(t.result.best_px) <= budget_us);
            CHECK(t.result.best_px <= 1.02 * right);
            CHECK(t.result.flights == t.flown.size());
            CHECK(t.result.flights <= 32);
        }
}

TEST_CASE("noise costs the tuner no more than its own size, and never has it offer what is dearer than that") {
    for (std::uint32_t seed = 1; seed <= 200; ++seed) {
        Cost cost;
        cost.seed = seed;
        cost.noise = 0.06;
        const Tuned t = tune(cost, asked(1000));
        const double right = cost.threshold(1000), found = t.result.best_px;
        INFO("seed " << seed << ": found " << found << ", is " << right);
        CHECK(cost.p99_us(found) <= 1000); // noise only adds: what keeps the budget with it does without
        CHECK(found <= 1.02 * cost.threshold(1000 / 1.06));
        CHECK(t.result.flights <= most_flights);
    }
}

TEST_CASE("frames that other programs spoil do not mislead the tuner") {
    int far = 0;
    for (std::uint32_t seed = 1; seed <= 200; ++seed) {
        Cost cost;
        cost.seed = seed;
        cost.spoiled = 0.05; // five times what p99 can bear in one flight
        const Tuned t = tune(cost, asked(1000));
        INFO("seed " << seed << ": found " << t.result.best_px << ", is " << cost.threshold(1000));
        CHECK(cost.p99_us(t.result.best_px) <= 1000);
        far += t.result.best_px > 1.03 * cost.threshold(1000) ? 1 : 0;
    }
    CHECK(far == 0); // spoiled three times over: 1 frame in 8,000
}

TEST_CASE("the threshold that is offered was flown, has three digits and keeps the budget in its last flights") {
    for (std::uint32_t seed = 1; seed <= 50; ++seed) {
        Cost cost;
        cost.seed = seed;
        cost.noise = 0.3;
        const Tuned t = tune(cost, asked(3000));
        REQUIRE(t.result.best_px > 0);
        CHECK(std::ranges::count(t.flown, t.result.best_px) >= 2);
        CHECK(t.flown.back() == t.result.best_px);
        CHECK(rounded_up(t.result.best_px) == t.result.best_px);
        const TunePoint* const best = t.result.at(t.result.best_px);
        REQUIRE(best != nullptr);
        CHECK(best->keeps);
        CHECK(best->p99_us <= 3000);
    }
}

TEST_CASE("where nothing keeps the budget the tuner says so, and where everything does it takes the least") {
    const Tuned none = tune({}, asked(10));
    CHECK(none.result.best_px == 0);
    CHECK(none.result.curve.size() == 1);
    CHECK(none.flown.size() <= 3);
    CHECK_THAT(tune_text(none.result, asked(10), "an orbit"),
               Catch::Contains("no threshold up to 32 px keeps the budget over an orbit") &&
                   Catch::Contains("p99 0.0109 ms of 0.01 ms"));
    const Tuned all = tune({}, asked(500'000));
    CHECK(all.result.best_px == 0.25);
    CHECK_THAT(tune_text(all.result, asked(500'000), "the path a.json"),
               Catch::Contains("0.25 px, the smallest allowed, over the path a.json: p99") &&
                   Catch::Contains(" of 500 ms"));
}

TEST_CASE("a threshold that the profile's budgets do not let it reach keeps nothing, however fast it is") {
    Cost cost;
    cost.reached_from = 3;
    const Tuned t = tune(cost, asked(500'000));
    CHECK(t.result.best_px >= 3);
    CHECK(t.result.best_px <= 3 * 1.02);
    CHECK_THAT(tune_text(t.result, asked(500'000), ""), Catch::Contains("a budget of the profile is the limit"));
    cost.reached_from = 100;
    const Tuned none = tune(cost, asked(500'000));
    CHECK(none.result.best_px == 0);
    CHECK_THAT(tune_text(none.result, asked(500'000), ""), Catch::Contains("50% of the frames"));
}

TEST_CASE("the curve falls from the largest threshold, grows flight by flight, and never promises fewer flights") {
    Cost cost;
    cost.noise = 0.1;
    const Tuned t = tune(cost, asked(1000));
    REQUIRE(t.published.size() > t.flown.size());
    for (std::size_t i = 0; i < t.published.size(); ++i) {
        const TuneResult& r = t.published[i];
        CHECK(r.flights == std::min(i + 1, t.flown.size()));
        CHECK(r.expected >= r.flights);
        CHECK(std::ranges::is_sorted(r.curve, std::ranges::greater{}, &TunePoint::error_px));
        if (i > 0) CHECK(r.curve.size() >= t.published[i - 1].curve.size());
    }
    CHECK(t.published.front().curve.size() == 1);
}

TEST_CASE("the tuner stops after a bounded number of flights, though each threshold fails when it is flown again") {
    std::vector<double> flown;
    TuneSettings settings = asked(1000);
    settings.least_px = 0.01;
    settings.most_px = 1000;
    const TuneResult r = find_threshold(
        settings,
        [&](double error_px) {
            const bool again = std::ranges::find(flown, error_px) != flown.end();
            flown.push_back(error_px);
            return FlightCost{
                std::vector<double>(50, error_px < 0.1 || (again && error_px < 900) ? 1100.0 : 800.0), 1, 1, {}};
        },
        [](const TuneResult&) {});
    CHECK(r.flights == flown.size());
    CHECK(flown.size() == most_flights);
    REQUIRE(r.at(r.best_px) != nullptr);
    CHECK(r.at(r.best_px)->keeps);
}

TEST_CASE("a threshold that fails beside one with room to spare is flown again, and the search goes on below it") {
    std::size_t at_four = 0;
    const Cost cost;
    const double right = cost.threshold(1000);
    REQUIRE(right < 2);
    const TuneResult r = find_threshold(
        asked(1000),
        [&](double error_px) {
            const bool spoiled = error_px == 4 && ++at_four <= 2;
            return FlightCost{std::vector<double>(50, cost.p99_us(error_px) * (spoiled ? 10 : 1)), 1, 1, {}};
        },
        [](const TuneResult&) {});
    CHECK(at_four > 2);
    CHECK(r.best_px >= right);
    CHECK(r.best_px <= 1.02 * right);
}

TEST_CASE("thresholds are rounded up to three digits") {
    CHECK(rounded_up(1.2301) == 1.24);
    CHECK(rounded_up(1.23) == 1.23);
    CHECK(rounded_up(0.9991) == 1);
    CHECK(rounded_up(0.012341) == 0.0124);
    CHECK(rounded_up(32) == 32);
    CHECK(rounded_up(123.1) == 124);
    CHECK(rounded_up(1000) == 1000);
    for (double e = 0.01; e < 1000; e *= 1.0137) {
        const double once = rounded_up(e);
        CHECK(once >= e * (1 - 1e-9));
        CHECK(once <= e * 1.0101);
        CHECK(rounded_up(once) == once);
    }
}

TEST_CASE("the curve as CSV has a line a threshold") {
    const Tuned t = tune({}, asked(1000));
    const std::string csv = tune_csv(t.result.curve);
    CHECK(csv.starts_with("threshold_px,p50_us,p99_us,max_us,vertices,frames,keeps,reached,flights\n32,"));
    CHECK(static_cast<std::size_t>(std::ranges::count(csv, '\n')) == t.result.curve.size() + 1);
}

TEST_CASE("settings of a tuning that are out of range are refused by their names") {
    const auto refuses = [](auto change, const std::string& name) {
        TuneSettings s;
        change(s);
        CHECK_THROWS_WITH(check(s), Catch::Contains(name));
    };
    CHECK_NOTHROW(check({}));
    refuses([](TuneSettings& s) { s.budget_us = 9; }, "budget_us");
    refuses([](TuneSettings& s) { s.budget_us = std::numeric_limits<double>::quiet_NaN(); }, "budget_us");
    refuses([](TuneSettings& s) { s.frames = 9; }, "frames");
    refuses([](TuneSettings& s) { s.frames = 100'001; }, "frames");
    refuses([](TuneSettings& s) { s.least_px = 0; }, "least_px");
    refuses([](TuneSettings& s) { s.most_px = s.least_px; }, "most_px");
    refuses([](TuneSettings& s) { s.most_px = 1001; }, "most_px");
}

TEST_CASE("what limits a threshold is the part that its dearest frames spend most on, and the text says it") {
    CHECK(limiting_part({}).name == nullptr);
    const LimitingPart limit = limiting_part({10, 20, 0, 0, 10, 160});
    CHECK(std::string(limit.name) == "drawing");
    CHECK(limit.share == Approx(0.8));
    const TuneResult r = find_threshold(
        asked(1000),
        [](double error_px) {
            return FlightCost{std::vector<double>(50, 400 / error_px), 1, 1,
                              std::vector<CostParts>(50, {0, 300 / error_px, 100 / error_px, 0, 0, 0})};
        },
        [](const TuneResult&) {});
    REQUIRE(r.best_px > 0);
    CHECK_THAT(tune_text(r, asked(1000), "an orbit"),
               Catch::Contains("limited by refining (75% of the slowest frames' time)"));
    // Where time is left nothing of it limits.
    CHECK_THAT(tune_text(find_threshold(
                             asked(500'000),
                             [](double) {
                                 return FlightCost{std::vector<double>(50, 400), 1, 1,
                                                   std::vector<CostParts>(50, {0, 300, 100, 0, 0, 0})};
                             },
                             [](const TuneResult&) {}),
                         asked(500'000), "an orbit"),
               Catch::Contains("the smallest allowed") && !Catch::Contains("limited by") &&
                   Catch::Contains("mostly for refining (75% of the slowest frames' time)"));
}

TEST_CASE("what limits a threshold is told from each frame's least time, so that what spoils frames of every flight "
          "does not falsify it") {
    // Refining takes three quarters of what a frame needs. In every flight another program takes ten times as much as
    // that from drawing, of every third frame, which are other ones the next time: no flight has an unspoiled p99.
    constexpr std::size_t frames = 90;
    std::size_t flights = 0;
    const TuneResult r = find_threshold(
        asked(1000),
        [&](double error_px) {
            FlightCost flight;
            for (std::size_t i = 0; i < frames; ++i) {
                const double needed_us = 400 / error_px; // of all frames, so that the parts of all are looked at
                const double spoiled_us = i % 3 == flights % 3 ? 10 * needed_us : 0;
                flight.times_us.push_back(needed_us + spoiled_us);
                flight.parts_us.push_back({0, 0.75 * needed_us, 0.25 * needed_us, 0, 0, spoiled_us});
            }
            ++flights;
            return flight;
        },
        [](const TuneResult&) {});
    REQUIRE(r.best_px > 0);
    const TunePoint& best = *r.at(r.best_px);
    REQUIRE(best.flights > 1); // or there is nothing to compare
    CHECK(best.keeps);
    CHECK(best.dearest_us[5] == 0);
    CHECK(std::accumulate(best.dearest_us.begin(), best.dearest_us.end(), 0.0) == Approx(best.p99_us));
    CHECK_THAT(tune_text(r, asked(1000), "an orbit"), Catch::Contains("limited by refining (75%"));
}

TEST_CASE("where one flight would do for a threshold, what is told of its time comes from both that there are") {
    constexpr std::size_t frames = 100;
    std::size_t flights = 0;
    const TuneResult r = find_threshold(
        asked(500'000), // so much that spoiled frames keep it too
        [&](double) {
            FlightCost flight{std::vector<double>(frames, 400), 1, 1,
                              std::vector<CostParts>(frames, {0, 300, 100, 0, 0, 0})};
            for (const std::size_t i : {flights % frames, (flights + 7) % frames}) { // other ones the next time
                flight.times_us[i] += 4000;
                flight.parts_us[i][5] += 4000;
            }
            ++flights;
            return flight;
        },
        [](const TuneResult&) {});
    const TunePoint* const best = r.at(r.best_px);
    REQUIRE(best != nullptr);
    CHECK(best->flights == 2);
    CHECK(best->p99_us == 400);
    CHECK(best->dearest_us == CostParts{0, 300, 100, 0, 0, 0});
    CHECK_THAT(tune_text(r, asked(500'000), "an orbit"), Catch::Contains("mostly for refining (75%"));
}
