#include "scene.h"

#include <cmath>

#include <OgreEntity.h>
#include <OgreGpuProgramParams.h>
#include <OgreHighLevelGpuProgram.h>
#include <OgreHighLevelGpuProgramManager.h>
#include <OgreLogManager.h>
#include <OgreMaterialManager.h>
#include <OgreShadowCameraSetup.h>
#include <OgreTechnique.h>
#include <OgreViewport.h>

namespace host {

namespace {

constexpr std::uint32_t shadow_texels = 2048;
constexpr float shadow_reach_m = 300, shadow_depth_m = 4000;
constexpr float shadow_texel_m = 2 * shadow_reach_m / shadow_texels;

const char* const group = Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME.c_str();

void make_program(const std::string& file, Ogre::GpuProgramType type) {
    auto& programs = Ogre::HighLevelGpuProgramManager::getSingleton();
    const Ogre::HighLevelGpuProgramPtr program = programs.createProgram(file, group, "glsl", type);
    program->setSourceFile(file);
    program->load();
    if (program->hasCompileError())
        OGRE_EXCEPT(Ogre::Exception::ERR_RENDERINGAPI_ERROR, file + " does not compile", "make_program");
}

Ogre::Vector3 vector(fjell::Vec3 v) {
    return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}
fjell::Vec3 vector(const Ogre::Vector3& v) {
    return {v.x, v.y, v.z};
}

// A square around what lies before the eye, as the sun sees it.
class SunShadow final : public Ogre::ShadowCameraSetup {
public:
    void getShadowCamera(const Ogre::SceneManager*, const Ogre::Camera* eye, const Ogre::Viewport*,
                         const Ogre::Light* sun, Ogre::Camera* camera, std::size_t) const override {
        const Ogre::Vector3 middle = eye->getDerivedPosition() + eye->getDerivedDirection() * (shadow_reach_m * 0.7f);
        const Ogre::Vector3 down = sun->getDerivedDirection();
        camera->setProjectionType(Ogre::PT_ORTHOGRAPHIC);
        camera->setOrthoWindow(2 * shadow_reach_m, 2 * shadow_reach_m);
        camera->setNearClipDistance(1);
        camera->setFarClipDistance(shadow_depth_m);
        camera->getParentNode()->setPosition(middle - down * (shadow_depth_m / 2));
        camera->getParentSceneNode()->setDirection(down, Ogre::Node::TS_WORLD);
    }
};

} // namespace

Scene::Scene(std::uint32_t width_px, std::uint32_t height_px, double fov_y_rad) {
    new Ogre::LogManager; // Root's, but for the console
    Ogre::LogManager::getSingleton().createLog("", true, false, true);
    root_ = std::make_unique<Ogre::Root>("", "", "");
    root_->loadPlugin(OGRE_PLUGINS "/RenderSystem_GL3Plus");
    root_->setRenderSystem(root_->getAvailableRenderers().front());
    root_->initialise(false);
    const Ogre::NameValuePairList options = {{"hidden", "true"}};
    try {
        window_ = root_->createRenderWindow("Fjell in OGRE", width_px, height_px, false, &options);
    } catch (...) {
        (void)root_.release(); // without a window it cannot be taken down
        throw;
    }
    auto& resources = Ogre::ResourceGroupManager::getSingleton();
    resources.addResourceLocation(OGRE_SHADERS, "FileSystem", group);
    resources.addResourceLocation(OGRE_SHADOW_MEDIA, "FileSystem", group); // OGRE looks for it with any shadow
    resources.initialiseAllResourceGroups();

    manager_ = root_->createSceneManager();
    manager_->setShadowTechnique(Ogre::SHADOWTYPE_TEXTURE_ADDITIVE_INTEGRATED);
    manager_->setShadowTextureSettings(shadow_texels, 1, Ogre::PF_DEPTH32);
    manager_->setShadowCameraSetup(std::make_shared<SunShadow>());
    manager_->setShadowFarDistance(shadow_reach_m);
    manager_->setShadowTextureSelfShadow(true);
    manager_->setShadowCasterRenderBackFaces(false); // ground has none
    make_programs();
    ground_material_ = make_material("ground", "terrain.vert", Ogre::ColourValue(0.23f, 0.28f, 0.13f, 1));
    boulder_material_ = make_material("boulder", "object.vert", Ogre::ColourValue(0.5f, 0.47f, 0.43f, 0));

    Ogre::Light* const sun = manager_->createLight("sun");
    sun->setType(Ogre::Light::LT_DIRECTIONAL);
    manager_->getRootSceneNode()->createChildSceneNode()->attachObject(sun);
    sun->getParentSceneNode()->setDirection(-vector(towards_sun()));

    camera_ = manager_->createCamera("eye");
    camera_node_ = manager_->getRootSceneNode()->createChildSceneNode();
    camera_node_->attachObject(camera_);
    camera_->setFOVy(Ogre::Radian(static_cast<float>(fov_y_rad)));
    camera_->setAspectRatio(static_cast<float>(width_px) / static_cast<float>(height_px));
    camera_->setNearClipDistance(0.5f);
    camera_->setFarClipDistance(60'000);
    window_->addViewport(camera_)->setBackgroundColour(Ogre::ColourValue(sky[0], sky[1], sky[2]));
}

Scene::~Scene() = default;

void Scene::make_programs() {
    make_program("terrain.vert", Ogre::GPT_VERTEX_PROGRAM);
    make_program("object.vert", Ogre::GPT_VERTEX_PROGRAM);
    make_program("lit.frag", Ogre::GPT_FRAGMENT_PROGRAM);
    make_program("caster.frag", Ogre::GPT_FRAGMENT_PROGRAM);
}

Ogre::MaterialPtr Scene::make_material(const std::string& name, const std::string& vertex,
                                       const Ogre::ColourValue& tint) {
    auto& materials = Ogre::MaterialManager::getSingleton();
    const auto bind = [&](Ogre::Pass& pass, const char* fragment) {
        pass.setVertexProgram(vertex);
        pass.setFragmentProgram(fragment);
        const auto& parameters = pass.getVertexProgramParameters();
        const auto automatic = [&](const char* uniform, Ogre::GpuProgramParameters::AutoConstantType type) {
            if (parameters->_findNamedConstantDefinition(uniform)) parameters->setNamedAutoConstant(uniform, type);
        };
        automatic("viewproj", Ogre::GpuProgramParameters::ACT_VIEWPROJ_MATRIX);
        automatic("world", Ogre::GpuProgramParameters::ACT_WORLD_MATRIX);
        if (parameters->_findNamedConstantDefinition("shadow_viewproj"))
            parameters->setNamedAutoConstant("shadow_viewproj", Ogre::GpuProgramParameters::ACT_TEXTURE_VIEWPROJ_MATRIX,
                                             0);
    };
    const Ogre::MaterialPtr caster = materials.create(name + "-caster", group);
    bind(*caster->getTechnique(0)->getPass(0), "caster.frag");
    const Ogre::MaterialPtr material = materials.create(name, group);
    Ogre::Technique& technique = *material->getTechnique(0);
    technique.setShadowCasterMaterial(caster);
    Ogre::Pass& pass = *technique.getPass(0);
    bind(pass, "lit.frag");
    const auto& parameters = pass.getFragmentProgramParameters();
    parameters->setNamedConstant("shadow_map", 0);
    parameters->setNamedConstant("sun", Ogre::Vector4(vector(fjell::normalised(towards_sun()))));
    parameters->setNamedConstant("tint", tint);
    parameters->setNamedConstant("shadow", Ogre::Vector4(1.0f / shadow_texels, shadow_texel_m / shadow_depth_m, 0, 0));
    Ogre::TextureUnitState& shadow = *pass.createTextureUnitState();
    shadow.setContentType(Ogre::TextureUnitState::CONTENT_SHADOW);
    shadow.setTextureAddressingMode(Ogre::TextureUnitState::TAM_CLAMP);
    shadow.setTextureFiltering(Ogre::TFO_NONE);
    return material;
}

void Scene::add(Ground& ground) {
    manager_->getRootSceneNode()->createChildSceneNode()->attachObject(&ground);
}

void Scene::add_boulders(const fjell::Terrain& terrain, fjell::Vec3 around_m, double radius_m) {
    const Ogre::MeshPtr sphere = manager_->createEntity(Ogre::SceneManager::PT_SPHERE)->getMesh(); // 50 units in radius
    for (int i = 0; i < 24; ++i) {
        const double angle = i * 2.4, away_m = radius_m * std::sqrt((i + 0.5) / 24), size_m = 1.5 + i % 5;
        fjell::Vec3 place_m = around_m + fjell::Vec3{std::cos(angle) * away_m, 0, std::sin(angle) * away_m};
        place_m.y = fjell::ground_height(terrain, place_m.x, place_m.z).height_m + 0.3 * size_m;
        Ogre::Entity* const entity = manager_->createEntity(sphere);
        entity->setMaterial(boulder_material_);
        Ogre::SceneNode* const node = manager_->getRootSceneNode()->createChildSceneNode();
        node->attachObject(entity);
        node->setScale(Ogre::Vector3(static_cast<float>(size_m / 50)));
        node->setPosition(vector(place_m - origin_m_));
        boulders_.push_back({node, place_m});
    }
}

void Scene::move_origin(fjell::Vec3 origin_m) {
    origin_m_ = origin_m;
    ++moves_;
    for (const Boulder& b : boulders_) b.node->setPosition(vector(b.place_m - origin_m_));
}

void Scene::look(fjell::Vec3 eye_m, fjell::Vec3 forward) {
    camera_node_->setPosition(vector(eye_m - origin_m_));
    camera_node_->lookAt(vector(eye_m - origin_m_ + forward * 100), Ogre::Node::TS_WORLD);
}

fjell::View Scene::view() const {
    const Ogre::Viewport& viewport = *camera_->getViewport();
    return fjell::make_view(vector(camera_->getDerivedPosition()) + origin_m_, vector(camera_->getDerivedDirection()),
                            vector(camera_->getDerivedUp()), camera_->getFOVy().valueRadians(),
                            static_cast<std::uint32_t>(viewport.getActualWidth()),
                            static_cast<std::uint32_t>(viewport.getActualHeight()), camera_->getNearClipDistance(),
                            camera_->getFarClipDistance());
}

void Scene::draw() {
    const auto eye = camera_node_->getPosition();
    for (const Ogre::MaterialPtr& material : {ground_material_, boulder_material_}) {
        const auto& parameters = material->getTechnique(0)->getPass(0)->getVertexProgramParameters();
        parameters->setNamedConstant("eye_in_scene_m", Ogre::Vector4(eye));
    }
    root_->renderOneFrame();
}

std::vector<unsigned char> Scene::picture() const {
    std::vector<unsigned char> bytes(std::size_t{3} * window_->getWidth() * window_->getHeight());
    const Ogre::PixelBox box(window_->getWidth(), window_->getHeight(), 1, Ogre::PF_BYTE_RGB, bytes.data());
    window_->copyContentsToMemory(box, box);
    return bytes;
}

} // namespace host
