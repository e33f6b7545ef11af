#include "dig.h"

#include <chrono>
#include <thread>

namespace server {

namespace {

constexpr int most_ticks = 5000;
constexpr double reach_m = 60, accuracy_m = 0.05;
constexpr float crater_m = 9, falloff_m = 5, deep_m = 4;

class Digging {
public:
    Digging(Zone& zone, ground::Yardstick& whole, Navmesh& navmesh)
        : zone_(zone), whole_(whole), navmesh_(navmesh), at_(walker_at(zone.ground.terrain(), 0, 0, 0)) {}

    Dug run() {
        if (!follow()) return fail("the tiles around a walker who stands still are not done");
        dug_.tiles = int(navmesh_.made());
        const std::uint64_t before = navmesh_.remade();
        fjell::Stamp crater;
        crater.shape = fjell::StampShape::crater;
        crater.x_m = at_.x, crater.z_m = at_.z;
        crater.radius_m = crater_m, crater.falloff_m = falloff_m, crater.amount_m = deep_m;
        // Nobody asks meanwhile, so that the yardstick may change first.
        if (std::string error = whole_.stamp(crater); !error.empty()) return fail(error);
        fjell::StampId id = 0;
        if (fjell::Status s = fjell::push_stamp(zone_.ground.edits(), crater, id); !s.ok())
            return fail(ground::text_of(s));
        digging_ = true;
        while (fjell::stamp_state(zone_.ground.edits(), id).state == fjell::StampState::waiting)
            if (!tick()) return fail("the crater waits for pages that do not come");
        if (fjell::Status s = fjell::stamp_state(zone_.ground.edits(), id).status; !s.ok())
            return fail(ground::text_of(s));
        if (!follow()) return fail("the tiles over a crater are not made again");
        dug_.again = int(navmesh_.remade() - before);
        if (dug_.touched == 0) return fail("the ground has changed, and no tile was told");
        if (dug_.again != dug_.touched) return fail("other tiles were made again than those in reach of the crater");
        return dug_;
    }

private:
    Dug fail(const std::string& what) {
        dug_.broken = !navmesh_.broken().empty() ? navmesh_.broken() : dug_.broken.empty() ? what : dug_.broken;
        return dug_;
    }
    // The ground of a tick, then one tile at most, which is timed.
    bool tick() {
        if (ticks_++ == most_ticks) return false;
        fjell::Vec3 eye = at_;
        eye.y = fjell::ground_height(zone_.ground.terrain(), at_.x, at_.z).height_m;
        const fjell::View view = ground::focus(eye, reach_m, accuracy_m);
        if (fjell::Status s = zone_.ground.update({&view, 1}, ticks_ * tick_s); !s.ok()) {
            dug_.broken = ground::text_of(s);
            return false;
        }
        zone_.loader->wake();
        dug_.touched += navmesh_.changed(zone_.ground.terrain(), zone_.ground.changes());
        navmesh_.want(zone_.ground.terrain(), at_);
        const std::uint64_t before = navmesh_.remade();
        const auto started = std::chrono::steady_clock::now();
        navmesh_.tick(1, whole_.terrain());
        if (digging_ && navmesh_.remade() != before)
            dug_.ms.push_back(
                std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - started).count());
        std::this_thread::yield();
        return navmesh_.broken().empty();
    }
    bool follow() {
        for (int quiet = 0; quiet < 20;) { // what a tick asks for it may find out in the next one
            if (!tick()) return false;
            const fjell::StreamReport& r = zone_.ground.report();
            quiet = navmesh_.done() && r.in_flight == 0 && r.pages_inserted == 0 ? quiet + 1 : 0;
        }
        return true;
    }

    Zone& zone_;
    ground::Yardstick& whole_;
    Navmesh& navmesh_;
    const fjell::Vec3 at_;
    bool digging_ = false;
    int ticks_ = 0;
    Dug dug_;
};

} // namespace

Dug dig(Zone& zone, ground::Yardstick& whole, Navmesh& navmesh) {
    return Digging(zone, whole, navmesh).run();
}

} // namespace server
