// OGRE without a configuration file: a window, materials from the shaders beside this file, a sun with a shadow.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <OgreCamera.h>
#include <OgreRenderWindow.h>
#include <OgreRoot.h>
#include <OgreSceneManager.h>
#include <OgreSceneNode.h>

#include <fjell/fjell.h>

#include "ground.h"

namespace host {

class Scene {
public:
    // Throws what OGRE throws: without a display, or without its render system.
    Scene(std::uint32_t width_px, std::uint32_t height_px, double fov_y_rad);
    ~Scene();
    Scene(const Scene&) = delete;
    Scene& operator=(const Scene&) = delete;

    void add(Ground& ground);
    // Boulders that stand on the ground, at places in metres of the terrain.
    void add_boulders(const fjell::Terrain& terrain, fjell::Vec3 around_m, double radius_m);

    // Everything in the scene counts from here: a whole cell near the eye, so that floats are fine enough.
    void move_origin(fjell::Vec3 origin_m);
    [[nodiscard]] fjell::Vec3 origin_m() const { return origin_m_; }
    [[nodiscard]] int moves() const { return moves_; } // of the origin
    void look(fjell::Vec3 eye_m, fjell::Vec3 forward);
    // What the camera sees, as the cut wants to know it.
    [[nodiscard]] fjell::View view() const;

    void draw();
    // Red, green, blue, row by row from above.
    [[nodiscard]] std::vector<unsigned char> picture() const;
    // In the last frame, without those of the shadow.
    [[nodiscard]] std::size_t triangles_drawn() const { return window_->getStatistics().triangleCount; }
    [[nodiscard]] fjell::Vec3 towards_sun() const { return {-0.3, 0.32, -0.9}; }

    [[nodiscard]] const Ogre::MaterialPtr& ground_material() const { return ground_material_; }
    static constexpr float sky[3] = {0.56f, 0.67f, 0.8f};

private:
    struct Boulder {
        Ogre::SceneNode* node;
        fjell::Vec3 place_m;
    };
    Ogre::MaterialPtr make_material(const std::string& name, const std::string& vertex, const Ogre::ColourValue& tint);
    void make_programs();

    std::unique_ptr<Ogre::Root> root_;
    Ogre::MaterialPtr ground_material_, boulder_material_; // go before OGRE does
    Ogre::RenderWindow* window_ = nullptr;
    Ogre::SceneManager* manager_ = nullptr;
    Ogre::Camera* camera_ = nullptr;
    Ogre::SceneNode* camera_node_ = nullptr;
    std::vector<Boulder> boulders_;
    fjell::Vec3 origin_m_;
    int moves_ = 0;
};

} // namespace host
