// Detail layers: rules, and what they say about a place.
#include <array>
#include <cstring>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "fjell/gl/layers.h"
#include "fjell/io/failure.h"
#include "io/file.h"
#include "session/layers_file.h"

using namespace fjell;

namespace {

io::Materials of_names(const std::vector<std::string>& names) {
    io::Materials materials;
    for (const std::string& name : names) {
        materials.records.emplace_back();
        std::memcpy(materials.records.back().name, name.c_str(), name.size() + 1);
    }
    return materials;
}

const io::Materials content =
    of_names({"dry_grass", "forest_floor", "grass", "gravel", "ice", "rock", "sand", "scree", "snow", "soil"});

void refuses_rules(const std::string& text, const std::string& message) {
    CHECK_THROWS_WITH((void)session::parse_layer_rules(text, "r.json", content),
                      Catch::StartsWith("r.json:" + message));
}

std::vector<double> shares_of(const std::vector<gl::LayerRule>& rules, double height_m, double slope_deg,
                              double noise = 0.5) {
    std::vector<double> shares(rules.size());
    gl::layer_shares(rules, height_m, slope_deg, noise, noise, shares);
    return shares;
}

} // namespace

TEST_CASE("the rules of content are read, and each place has layers that add up to all of it") {
    for (const char* const name : {"alpine", "canyon", "nordic"}) {
        const std::string file = std::string(FJELL_SOURCE_DIR "/content/materials/rules/") + name + ".json";
        const std::vector<gl::LayerRule> rules = session::parse_layer_rules(io::read_text(file), file, content);
        gl::validate(rules, content.records.size());
        for (double height_m = -500; height_m < 4500; height_m += 97)
            for (double slope_deg = 0; slope_deg <= 90; slope_deg += 7)
                for (const double noise : {0.0, 0.3, 0.5, 0.8, 1.0}) {
                    double all = 0;
                    for (const double share : shares_of(rules, height_m, slope_deg, noise)) {
                        CHECK(share >= 0);
                        all += share;
                    }
                    CHECK(all == Approx(1));
                }
    }
}

TEST_CASE("a rule covers those before it, within its ranges, and its edges are as soft as it says") {
    gl::LayerRule grass{.material = 2},
        snow{.material = 8, .height_m = {2000, gl::open_height_m}, .height_soft_m = 200, .ragged = 0};
    gl::LayerRule rock{.material = 5, .slope_deg = {40, 90}, .slope_soft_deg = 10, .ragged = 0, .opacity = 0.5};
    const std::vector<gl::LayerRule> rules{grass, snow, rock};
    CHECK(shares_of(rules, 1000, 10) == std::vector<double>{1, 0, 0});
    CHECK(shares_of(rules, 2100, 10) == std::vector<double>{0, 1, 0});
    CHECK(shares_of(rules, 2000, 10)[1] == Approx(0.5));
    CHECK(shares_of(rules, 1950, 10)[1] == Approx(0.25));
    CHECK(shares_of(rules, 1000, 60) == std::vector<double>{0.5, 0, 0.5});
    CHECK(shares_of(rules, 3000, 40)[2] == Approx(0.25)); // half way in, half of it
    CHECK(shares_of(rules, 3000, 90)[2] == Approx(0.5));  // an open end has no edge
    // Noise moves a ragged edge by its softness.
    rock.ragged = 1;
    CHECK(shares_of({grass, rock}, 0, 39, 0.6)[1] == Approx(0.25));
    // Nothing anywhere is nothing, not a division by it.
    CHECK(shares_of({snow}, 0, 0) == std::vector<double>{0});
}

TEST_CASE("what is wrong with rules is said with file, line, rule, layer and key") {
    refuses_rules("[]", " is not a JSON object");
    refuses_rules("{}", " \"rules\" must be a list of 1 to 16 rules");
    refuses_rules(R"({"rules": [{"layer": "rock"}], "fog": 1})", " unknown field \"fog\"");
    refuses_rules(R"({"rules": [{"layer": "rock"}, {}]})",
                  "1: rule 1: \"layer\" must name a material, one of dry_grass, ");
    refuses_rules(R"({"rules": [{"layer": "moss"}]})",
                  "1: rule 0 (moss): there is no such material; there are dry_grass, ");
    refuses_rules(R"({"rules": [{"layer": "rock", "slope": 3}]})", "1: rule 0 (rock): unknown field \"slope\"");
    refuses_rules(R"({"rules": [{"layer": "rock", "slope_deg": [50, 40]}]})",
                  "1: rule 0 (rock): \"slope_deg\" must be two numbers in 0..90, the lower first, or null for no end");
    refuses_rules(R"({"rules": [{"layer": "rock", "opacity": 2}]})",
                  "1: rule 0 (rock): \"opacity\" must be a number in 0..1");
    refuses_rules("{\n  // two\n  \"rules\": [\n    {\"layer\": \"rock\"},\n    {\"layer\": \"rock\",\n     \"noise\": "
                  "1}\n  ]\n}",
                  "5: rule 1 (rock): \"noise\" must be two numbers");
    std::string many = R"({"rules": [{"layer": "rock"})";
    for (int i = 0; i < 16; ++i) many += R"(, {"layer": "rock"})";
    refuses_rules(many + "]}", " \"rules\" must be a list of 1 to 16 rules");
}

TEST_CASE("settings and rules out of range are refused by name") {
    gl::validate(gl::LayerSettings{});
    CHECK_THROWS_WITH(gl::validate(gl::LayerSettings{.distance_m = 0}),
                      "LayerSettings::distance_m must be a number from 1 to 100000");
    CHECK_THROWS_WITH(gl::validate(gl::LayerSettings{.tint = 2}), "LayerSettings::tint must be a number from 0 to 1");
    CHECK_THROWS_WITH(gl::validate(gl::LayerSettings{.relief = -1}),
                      "LayerSettings::relief must be a number from 0 to 4");
    const std::array bad{gl::LayerRule{}, gl::LayerRule{.material = 3}};
    CHECK_THROWS_WITH(gl::validate(bad, 3), "rule 1: material must be one of the materials");
    CHECK_THROWS_WITH(gl::validate(std::array{gl::LayerRule{.noise = {0.5, 0.4}}}, 1),
                      "rule 0: noise must be two numbers from 0 to 1, the lower first");
    CHECK_THROWS_WITH(gl::validate({}, 1), "there must be 1 to 16 rules");
}
