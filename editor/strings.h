// What a user of the editor reads, in its window and of a run without one: all of it, and nothing else.
//
// First each panel has a namespace, called as its source, with `common` for what several say and `keys` for what keys
// are called: `spacing` is a label, `about_spacing` its tooltip, `spacing_hint` what an empty field says. Behind them
// stands what is not of one panel: `refusals`, `notices`, `results` and smaller ones. Formats are arrays, so that
// compilers compare them with their arguments: printf's in panels, fmt's elsewhere. Test: unit_editor,
// editor_strings_test. Elsewhere, beside what they describe: what --help and --help-commands print (options.cpp, the
// tables of verbs in *command*.cpp), names of commands, modes and jobs (names.h, jobs/jobs.h), of graphs and of a job's
// stages, which are ids too, and of profile keys (flight/profile_keys.cpp). Thread: any. Memory: none. Failure: none.
#pragma once

namespace fjell::editor::strings {

namespace common {
inline constexpr char auto_[] = "auto";
inline constexpr char add[] = "Add";
inline constexpr char remove[] = "Remove";
inline constexpr char heights[] = "Heights";
inline constexpr char none[] = "none";
inline constexpr char bake[] = "Bake";
inline constexpr char vertices[] = "Vertices";
inline constexpr char triangles[] = "Triangles";
inline constexpr char work_items[] = "Work items";
inline constexpr char page_slots[] = "Page slots";
inline constexpr char upload_per_frame[] = "Upload per frame";
inline constexpr char stream[] = "Stream";
inline constexpr char total[] = "Total";
inline constexpr char no_terrain_is_open[] = "No terrain is open.";
inline constexpr char fly[] = "Fly";
inline constexpr char orbit[] = "Orbit";
inline constexpr char off[] = "off";
inline constexpr char open[] = "Open";
inline constexpr char save_profile[] = "Save profile";
inline constexpr char keys[] = "Keys";
inline constexpr char messages[] = "Messages";
inline constexpr char cancel[] = "Cancel";
inline constexpr char close[] = "Close";
inline constexpr char up[] = "Up";
inline constexpr char save[] = "Save";
inline constexpr char open_the_sample[] = "Open the sample";
inline constexpr char restore[] = "Restore";
inline constexpr char camera[] = "Camera";
inline constexpr char camera_path[] = "Camera path";
inline constexpr char picture[] = "Picture";
inline constexpr char mesh[] = "Mesh";
inline constexpr char file[] = "File";
inline constexpr char png_hint[] = "a file that ends in .png";
inline constexpr char about_png[] = "Where the PNG is written.";
inline constexpr char open_dots[] = "Open...";
inline constexpr char stop_recording[] = "Stop recording";
inline constexpr char pause[] = "Pause";
inline constexpr char view[] = "View";
inline constexpr char auto_tune[] = "Auto-tune";
inline constexpr char benchmark[] = "Benchmark";
inline constexpr char streaming[] = "Streaming";
inline constexpr char levels[] = "Levels";
inline constexpr char distance[] = "Distance";
inline constexpr char slope[] = "Slope";
inline constexpr char max[] = "max";
inline constexpr char unbounded[] = "unbounded";
inline constexpr char lags[] = "lags";
inline constexpr char budget[] = "budget";
inline constexpr char vertices_unit[] = "vertices";
} // namespace common

namespace keys {
inline constexpr char home[] = "Home";
inline constexpr char f[] = "F";
inline constexpr char r[] = "R";
inline constexpr char n[] = "N";
inline constexpr char p[] = "P";
inline constexpr char g[] = "G";
inline constexpr char i[] = "I";
inline constexpr char t[] = "T";
inline constexpr char tab[] = "Tab";
inline constexpr char f11[] = "F11";
inline constexpr char f6[] = "F6";
inline constexpr char ctrl_o[] = "Ctrl+O";
inline constexpr char ctrl_s[] = "Ctrl+S";
inline constexpr char f1[] = "F1";
inline constexpr char ctrl_q[] = "Ctrl+Q";
inline constexpr char ctrl_shift_s[] = "Ctrl+Shift+S";
inline constexpr char ctrl_z[] = "Ctrl+Z";
inline constexpr char ctrl_shift_z[] = "Ctrl+Shift+Z";
inline constexpr char bracket_left[] = "[";
inline constexpr char bracket_right[] = "]";
inline constexpr char m[] = "M";
} // namespace keys

namespace bake {
inline constexpr char auto_no_data[] = "auto: holes; suspicious values are refused";
inline constexpr char take_proposal[] = "Use %.32s";
inline constexpr char about_proposal[] = "Takes what the line below proposes.";
inline constexpr char browse[] = "Browse";
inline constexpr char about_add[] = "Adds a file: several make a mosaic.";
inline constexpr char more_options[] = "More options";
inline constexpr char no_data[] = "No data";
inline constexpr char about_no_data[] =
    "What becomes of samples without a height: they stay a hole, are filled from their neighbours, or are refused.";
inline constexpr char voids[] = "Voids";
inline constexpr char voids_hint[] = "what the file marks";
inline constexpr char about_voids[] =
    "Numbers that mean \"no height\" although the file does not say so, such as -9999; separate several by commas. "
    "none: every number that the file does not mark is a height.";
inline constexpr char crs[] = "CRS";
inline constexpr char crs_hint[] = "the file's own; degrees become UTM";
inline constexpr char about_crs[] =
    "The coordinate reference system to reproject to, such as EPSG:25832. none: nothing is reprojected.";
inline constexpr char tile[] = "Tile";
inline constexpr char about_tile[] = "Cells along a side of a tile, the unit of drawing. Smaller tiles are culled more "
                                     "tightly and cost more draw calls; auto chooses 512, or what suits the extents.";
inline constexpr char order[] = "Order";
inline constexpr char about_order[] = "Order of the vertices in a page: planar and hz (hierarchical Z) suit both "
                                      "methods; linear, as in the thesis, suits the recursive method alone.";
inline constexpr char heights_hint[] = "a file, or drop one here";
inline constexpr char about_heights[] =
    "GeoTIFF, PNG, BMP, ASCII grid, HGT, USGS DEM, netCDF, VRT; or a recipe (.json).";
inline constexpr char pack[] = "Pack";
inline constexpr char pack_hint[] = "beside the heights, with .fjell";
inline constexpr char about_pack[] =
    "Where the pack is written. An existing one is replaced once you have agreed and the bake is complete.";
inline constexpr char spacing_m[] = "Spacing, m";
inline constexpr char about_spacing[] =
    "Metres between samples. 0: the file's own. Needed where the file has no coordinates.";
inline constexpr char height_scale[] = "Height scale";
inline constexpr char about_height_scale[] =
    "Multiplies heights: 0.3048 converts feet to metres. 1: as the file has them.";
inline constexpr char height_offset_m[] = "Height offset, m";
inline constexpr char about_height_offset[] = "Added to heights, after the scale.";
inline constexpr char texture[] = "Texture";
inline constexpr char about_texture[] =
    "An ortho-image, placed by its coordinates, or stretched over the terrain where it has none.";
inline constexpr char ramp[] = "Ramp";
inline constexpr char ramp_hint[] = "by height, from meadows to snow";
inline constexpr char about_ramp[] = "Colours by height and slope where there is no image (JSON, as in content/ramps).";
inline constexpr char rules[] = "Rules";
inline constexpr char about_rules[] =
    "Rules for control maps: which materials lie where, by height, slope, curvature, aspect, wetness and noise, by "
    "rasters and paint (JSON, as in content/materials/control).";
inline constexpr char control_maps[] = "Control maps";
inline constexpr char about_control_maps[] = "How fine the rules' control maps are: full has a texel for each sample, "
                                             "half one for 2 x 2 samples, quarter one for 4 x 4.";
inline constexpr char horizons[] = "Horizons";
inline constexpr char about_horizons[] =
    "Horizon maps, for shadows at any time of day: half has a texel for 2 x 2 samples, quarter one for 4 x 4.";
inline constexpr char count_of_rules[] = "%zu, %zu materials";
inline constexpr char other_materials[] = "others";
inline constexpr char no_material[] = "without a material";
inline constexpr char extract[] = "Extract";
inline constexpr char extract_hint[] = "all of it";
inline constexpr char about_extract[] =
    "Only what lies within west,south,east,north: units of the CRS after reprojection, or columns and rows from the "
    "north-west where there are no coordinates.";
inline constexpr char encoding[] = "Encoding";
inline constexpr char about_encoding[] =
    "How heights are packed into red, green and blue: terrarium or terrain-rgb (Mapbox). none: one band of heights.";
inline constexpr char about_strip[] = "The ramp's colours, from the lowest height to the highest.";
inline constexpr char about_picture_with_texture[] =
    "The heights in the colours of the ramp, and beside them the texture.";
inline constexpr char about_picture[] = "The heights in the colours that the terrain will have; where rules lay "
                                        "materials, in the colours of the list below.";
inline constexpr char reading_heights[] = "Reading the heights...";
inline constexpr char facts_appear_here[] = "Size, heights and coordinates of the file are shown here.";
inline constexpr char about[] = "about ";
inline constexpr char height_range[] = "%s%s to %s m";
inline constexpr char samples[] = "Samples";
inline constexpr char spacing[] = "Spacing";
inline constexpr char extents[] = "Extents";
inline constexpr char no_unit[] = "No unit is named: heights are taken as metres";
inline constexpr char no_crs[] = "No coordinate reference system";
inline constexpr char reprojected_from[] = ", reprojected from ";
inline constexpr char reading_files[] = "Reading the files...";
inline constexpr char choose_heights[] = "Choose a file of heights: browse, type, or drop it on the window.";
inline constexpr char problem_with_proposal[] = "%s. Proposed: %s, %s.";
inline constexpr char few_seconds[] = "a few seconds";
inline constexpr char duration[] = "about %.0f %s";
inline constexpr char seconds[] = "seconds";
inline constexpr char minutes[] = "minutes";
inline constexpr char plan[] = "Writes %s: %s to %s, in %s, in the background.%s %s%s%s";
inline constexpr char plan_replaces[] = " A pack of that name is there; you are asked before it is replaced.";
inline constexpr char plan_asks[] = "When it is done, you are asked whether to leave ";
inline constexpr char plan_opens[] = "Then it is opened.";
inline constexpr char choose_a_file[] = "Choose a file";
inline constexpr char choose[] = "Choose";
inline constexpr char about_bake[] = "Bakes in the background with 512 MB of memory (Enter).";
inline constexpr char pack_is_ready[] = "%s is ready. Fly it, and leave %s?";
inline constexpr char fly_it[] = "Fly it";
inline constexpr char not_now[] = "Not now";
inline constexpr char about_not_now[] = "The pack stays on the disk: open it with File > Open.";
} // namespace bake

namespace budgets {
inline constexpr char no_limit[] = "no limit";
inline constexpr char row_help[] = "%s\nRaise it with %s.";
inline constexpr char double_[] = "Double";
inline constexpr char about_double[] = "Twice as much, from the next frame on.";
inline constexpr char about_double_memory[] = "Twice as much. Memory is reallocated; the view stays.";
inline constexpr char exhausted[] = "exhausted: %s";
inline constexpr char refinement[] = "Refinement:  used | peak | limit";
inline constexpr char about_vertices[] = "Slots of the vertex buffer. At the limit, the threshold rises.";
inline constexpr char indices[] = "Indices";
inline constexpr char about_indices[] = "Slots of the index buffer. At the limit, the threshold rises.";
inline constexpr char about_triangles[] =
    "Slots of the index buffer, in whole segments. At the limit, the threshold rises.";
inline constexpr char about_work_items[] =
    "Vertices that an update examines or changes. At the limit, the mesh lags behind the camera.";
inline constexpr char time_ms[] = "Time, ms";
inline constexpr char about_time[] = "Time that an update may take. At the limit, the mesh lags behind the camera.";
inline constexpr char streaming[] = "Streaming:  used | peak | limit";
inline constexpr char about_page_slots[] = "Pages in memory. At the limit, distant terrain is coarser than requested.";
inline constexpr char requests[] = "Requests";
inline constexpr char about_requests[] =
    "Pages and mips in flight (stream.map_requests for mips). At the limit, further requests wait.";
inline constexpr char pages_per_frame[] = "Pages per frame";
inline constexpr char about_pages_per_frame[] =
    "Accepted pages, 10 to 20 us each. At the limit, pages wait for the next frame.";
inline constexpr char map_memory[] = "Map memory";
inline constexpr char about_map_memory[] = "Maps on the GPU. At the limit, distant maps are blurrier than requested.";
inline constexpr char about_map_upload[] = "Maps uploaded to the GPU; one mip may exceed it.";
inline constexpr char pages_tested[] = "Pages tested";
inline constexpr char limit_reached[] = "limit reached";
inline constexpr char within_the_limit[] = "within the limit";
inline constexpr char about_pages_tested[] =
    "Pages that an update of the stream tests (stream.tests). Raise it when the limit is reached.";
inline constexpr char memory[] = "Memory";
inline constexpr char terrain[] = "Terrain";
inline constexpr char about_terrain[] = "Page slots, page table and corners.";
inline constexpr char method[] = "Method";
inline constexpr char about_method[] = "Vertices, indices and bookkeeping.";
inline constexpr char about_stream[] = "Requests in flight and their buffers.";
inline constexpr char gpu_mesh[] = "GPU: mesh";
inline constexpr char about_gpu_mesh[] = "Vertex and index buffers, without staging buffers.";
inline constexpr char gpu_maps[] = "GPU: maps";
inline constexpr char about_gpu_maps[] = "Textures of colours and normals.";
inline constexpr char about_total[] = "Host and GPU, without the program itself.";
} // namespace budgets

namespace camera {
inline constexpr char east[] = "East";
inline constexpr char about_east[] = "Metres east of the terrain's first sample. Enter applies it.";
inline constexpr char south[] = "South";
inline constexpr char about_south[] = "Metres south of the terrain's first sample. Enter applies it.";
inline constexpr char height[] = "Height";
inline constexpr char about_height[] = "Metres above height 0; never below the ground. Enter applies it.";
inline constexpr char above_ground[] = "Above ground";
inline constexpr char about_above_ground[] = "Metres above the ground under the camera. Enter applies it.";
inline constexpr char heading[] = "Heading";
inline constexpr char about_heading[] = "Degrees clockwise from north. Enter applies it.";
inline constexpr char pitch[] = "Pitch";
inline constexpr char about_pitch[] = "Degrees up from the horizon, -86 to 86. Enter applies it.";
inline constexpr char path[] = "Path";
inline constexpr char about_fly[] = "W, A, S, D, Q and E move, dragging looks around, the wheel sets the speed (1).";
inline constexpr char about_orbit[] =
    "Dragging orbits the ground in the middle of the picture, the wheel zooms, right drag pans (2).";
inline constexpr char about_path[] = "Follows the camera path (3).";
inline constexpr char view_all[] = "View all";
inline constexpr char about_view_all[] = "Look at the whole terrain from the south (Home).";
inline constexpr char speed[] = "Speed";
inline constexpr char about_speed[] = "Flying speed in metres per second; with Shift five times as fast. The wheel "
                                      "over the picture changes it too; Ctrl+click to type a value.";
inline constexpr char freeze[] = "Freeze refinement (F)";
inline constexpr char about_freeze[] = "The mesh stays refined and culled for the current camera while you look at it "
                                       "from elsewhere. The overview shows both cameras.";
inline constexpr char position[] = "Position";
} // namespace camera

namespace compare_picture {
inline constexpr char threshold[] = "threshold";
inline constexpr char profile[] = "profile";
inline constexpr char divider[] = "Divider";
inline constexpr char about_divider[] = "Where the divider stands, in percent of the picture's width. Or drag it.";
inline constexpr char about_off[] = "The profile alone.";
inline constexpr char about_threshold[] = "This profile at another threshold, in the same picture.";
inline constexpr char about_profile[] = "The profile chosen with File > Compare profiles, in the same picture.";
inline constexpr char no_profile_chosen[] = "First choose a profile with File > Compare profiles.";
inline constexpr char about_other_threshold[] = "The other threshold, in pixels. Enter applies it.";
inline constexpr char compared[] = "%.3g px, %s triangles";
inline constexpr char compared_opening[] = "%.3g px: opening";
inline constexpr char heading[] = "Compare in the picture";
inline constexpr char side_by_side[] = "side by side";
inline constexpr char difference[] = "difference";
inline constexpr char about_side_by_side[] =
    "On the left the profile, on the right the other one; drag the divider in the picture.";
inline constexpr char about_difference[] = "Black where both pictures are the same, through blue and yellow to white "
                                           "where they differ by an eighth of full brightness or more.";
inline constexpr char about_divider_handle[] =
    "Drag: the profile on the left, the one it is compared with on the right.";
} // namespace compare_picture

namespace dialogs {
inline constexpr char welcome_to_fjell[] = "Welcome to Fjell";
inline constexpr char save_camera_path[] = "Save camera path";
inline constexpr char compare_profiles[] = "Compare profiles";
inline constexpr char export_gltf[] = "Export glTF";
inline constexpr char screenshot[] = "Screenshot";
inline constexpr char unsaved_changes[] = "Unsaved changes";
inline constexpr char recovered_changes[] = "Recovered changes";
inline constexpr char the_pack_is_ready[] = "The pack is ready";
} // namespace dialogs

namespace fields {
inline constexpr char about_cancel[] = "Stops the job; no partial file remains.";
inline constexpr char about_close[] = "Closes this dialog (Esc); a running job goes on.";
inline constexpr char rate_and_time_left[] = "  %.1f M/s  %.0f s left";
inline constexpr char time_left[] = "  %.0f s left";
inline constexpr char another_job_runs[] = "Another job is running: wait for it, or cancel it.";
inline constexpr char cancelled[] = "Cancelled%s%s";
inline constexpr char writes[] = "Writes %s/%s";
} // namespace fields

namespace file_browser {
inline constexpr char reload[] = "Reload";
inline constexpr char recent_folders[] = "Folders of recent files";
inline constexpr char folder[] = "folder";
inline constexpr char name[] = "Name";
inline constexpr char size[] = "Size";
inline constexpr char none_of_this_kind[] = "no files of this kind here";
inline constexpr char empty_folder[] = "this folder is empty";
inline constexpr char name_hint[] = "a name or a full path";
inline constexpr char all_files[] = "All files";
inline constexpr char about_all_files[] = "Lists files of other kinds as well.";
inline constexpr char overwrite_question[] = "Overwrite?";
inline constexpr char exists_already[] = "%s already exists.";
inline constexpr char overwrite_button[] = "Overwrite";
inline constexpr char choose_another_name[] = "Choose another name";
} // namespace file_browser

namespace file_dialogs {
inline constexpr char recent_packs[] = "Recent packs";
inline constexpr char none_yet[] = "None yet.";
inline constexpr char differences[] = "Compared with %s: %zu keys differ.";
inline constexpr char the_saved_profile[] = "the saved profile";
inline constexpr char key[] = "Key";
inline constexpr char mine[] = "Mine";
inline constexpr char theirs[] = "Theirs";
inline constexpr char take_theirs_column[] = "Take theirs   ";
inline constexpr char take_theirs[] = "Take theirs";
inline constexpr char welcome[] = "Fjell draws large terrains with a bounded screen-space error. This editor tunes its "
                                  "thresholds and budgets, by eye and by number.";
inline constexpr char about_sample[] =
    "A small synthetic landscape. It is baked when first used, which takes a few seconds.";
inline constexpr char open_a_file[] = "Open a file...";
inline constexpr char about_open_a_file[] =
    "A pack (.fjell), a profile, or heights to be baked, in any format that GDAL reads.";
inline constexpr char about_bake[] =
    "Makes a pack from a DEM: GeoTIFF, PNG, ASCII grid or any other format that GDAL reads.";
inline constexpr char or_drop_a_file[] = "Or drop a file onto the window.";
inline constexpr char with_the_saved_profile[] = "With the saved profile";
inline constexpr char or_another_profile[] = "or with another profile:";
inline constexpr char compare[] = "Compare";
inline constexpr char compare_another[] = "Compare another";
inline constexpr char about_compare_another[] = "Compares with another profile.";
inline constexpr char stop_comparing[] = "Stop comparing";
inline constexpr char about_close_comparison[] = "The other profile's values stay visible in the Tune panel.";
inline constexpr char unsaved_profile[] = "The profile has unsaved changes: %s.";
inline constexpr char no_file_yet[] = "it has no file yet";
inline constexpr char unsaved_path[] = "The camera path has unsaved changes: %s.";
inline constexpr char discard[] = "Discard";
inline constexpr char nothing_to_recover[] = "There is nothing to recover.";
inline constexpr char earlier_run[] = "The editor ended before these changes were saved.";
inline constexpr char of_the_profile[] = "of the profile %s";
inline constexpr char profile_without_file[] = "that had no file yet";
inline constexpr char recovered_path[] = "a camera path of %zu points";
inline constexpr char over_terrain[] = "over %s";
inline constexpr char about_later[] = "close this dialog to be asked again next time";
} // namespace file_dialogs

namespace graph {
inline constexpr char frames_ago[] = "%zu frames ago";
inline constexpr char hand_help[] = "click: its report; drag: zoom in";
inline constexpr char billions[] = "%.3g G";
inline constexpr char keys_help[] = "Enter: the report of its highest frame.";
} // namespace graph

namespace help {
inline constexpr char fly_keys[] = "W S, A D";
inline constexpr char about_fly_keys[] = "fly forwards and back, left and right; in orbit: pan";
inline constexpr char height_keys[] = "E Q";
inline constexpr char about_height_keys[] = "up and down";
inline constexpr char shift_key[] = "Shift";
inline constexpr char about_shift_key[] = "five times as fast";
inline constexpr char look_keys[] = "Arrows, left drag";
inline constexpr char about_look_keys[] = "look around; in orbit: turn around the centre";
inline constexpr char wheel[] = "Wheel";
inline constexpr char about_wheel[] = "speed; in orbit: zoom";
inline constexpr char pan_drag[] = "Right drag, Shift+drag";
inline constexpr char about_pan_drag[] = "in orbit: pan";
inline constexpr char about_navigation_keys[] = "fly, orbit, follow the path";
inline constexpr char about_home[] = "look at the whole terrain";
inline constexpr char overview_click[] = "Click on the overview";
inline constexpr char about_overview_click[] = "fly there, at the same height above the ground";
inline constexpr char about_freeze[] = "freeze refinement, to look at the mesh from elsewhere";
inline constexpr char about_record[] = "record the flight; again: stop recording";
inline constexpr char about_add_point[] = "add a point where the camera is";
inline constexpr char point_drag[] = "Left drag on a point";
inline constexpr char about_point_drag[] =
    "move it, in the picture (Shift: up and down) or on the overview; a click selects it";
inline constexpr char timeline_keys[] = "Arrows on the timeline";
inline constexpr char about_timeline_keys[] =
    "select a point; with Shift: its time, or up and down the speed after it; Enter: look from there";
inline constexpr char about_play[] = "play; again: pause";
inline constexpr char mode_keys[] = "M, Shift+M";
inline constexpr char about_mode_keys[] = "next and previous picture mode";
inline constexpr char about_wireframe[] = "wireframe";
inline constexpr char sun_drag[] = "L and left drag";
inline constexpr char about_sun_drag[] = "the sun: across its azimuth, up and down its elevation";
inline constexpr char about_probe[] = "probe the ground under the pointer, or where the camera looks; a click or Enter "
                                      "marks a place, another one measures from there";
inline constexpr char about_pause[] = "pause graphs and times; again: go on";
inline constexpr char window[] = "Window";
inline constexpr char about_tab[] = "hide the panels, or show them";
inline constexpr char about_picture_only[] = "the picture alone; again or Esc: all of it";
inline constexpr char about_panel_keys[] =
    "move in the panels by keys: Tab and arrows move, Enter presses, Space changes a value; again: the next panel, "
    "after the last one the camera; Shift+F6: the one before; Esc: the camera";
inline constexpr char menu_keys[] = "F10, Alt+F, Alt+E, ...";
inline constexpr char about_menu_keys[] =
    "the first menu; again: the next one; Alt and its first letter: any; arrows move, Enter chooses";
inline constexpr char panel_turn_keys[] = "Ctrl+Page Up, Page Down";
inline constexpr char about_panel_turn_keys[] = "turn to the panel before or after";
inline constexpr char floating_keys[] = "Ctrl+Tab and arrows";
inline constexpr char about_floating_keys[] = "with F6: move a floating panel; with Shift: resize it";
inline constexpr char scroll_keys[] = "Page Up, Page Down";
inline constexpr char about_scroll_keys[] = "scroll this list";
inline constexpr char dialog_keys[] = "Enter, Esc";
inline constexpr char about_dialog_keys[] = "in a dialog: its main button, or close it";
inline constexpr char profile_and_program[] = "Profile and program";
inline constexpr char about_threshold_keys[] = "lower, raise the threshold";
inline constexpr char undo_keys[] = "Ctrl+Z, Ctrl+Shift+Z";
inline constexpr char about_undo_keys[] = "undo, redo";
inline constexpr char about_open[] = "open a pack, a DEM, a profile or a camera path";
inline constexpr char about_save[] = "save the profile";
inline constexpr char slider_click[] = "Ctrl+click on a slider";
inline constexpr char about_slider_click[] = "type a value";
inline constexpr char about_keys[] = "this list of keys";
inline constexpr char about_quit[] = "quit";
inline constexpr char no_messages_yet[] = "No messages yet.";
inline constexpr char times[] = "(%u times)";
} // namespace help

namespace job_dialogs {
inline constexpr char frames_own[] = "the frame's";
inline constexpr char custom_threshold[] = "custom threshold";
inline constexpr char gltf[] = "glTF";
inline constexpr char gltf_hint[] = "a file that ends in .glb";
inline constexpr char about_gltf[] = "Mesh, colours and camera in one file, for any viewer or modelling program.";
inline constexpr char about_mesh[] =
    "The frame's is written as it is drawn: the triangles that the camera sees, morphed, as fine as the budgets "
    "allowed. A custom threshold refines the whole terrain for this view, whatever the budgets.";
inline constexpr char converged[] = "Converged";
inline constexpr char about_converged[] =
    "The mesh that this view settles on once it has had time and work items, instead of the frame's as it stands.";
inline constexpr char pixels[] = "Pixels";
inline constexpr char about_pixels[] = "0.01 to 1,000 pixels: a smaller threshold makes a larger file.";
inline constexpr char preview[] = "Preview";
inline constexpr char about_preview[] = "Counts, and the size of the file to the byte; nothing is written.";
inline constexpr char export_[] = "Export";
inline constexpr char about_export[] = "Writes the file; an existing one is replaced only when it is complete.";
inline constexpr char size_within[] = "%s within %.3g px";
inline constexpr char terrain_alone[] = "the terrain";
inline constexpr char window_with_panels[] = "the window, with its panels";
inline constexpr char contents[] = "Contents";
inline constexpr char about_contents[] = "At the current size of the window.";
inline constexpr char about_save[] = "Closes this dialog and saves the next frame.";
inline constexpr char about_cancel[] =
    "Stops the job; no partial file remains. A bake may keep a folder from which it can resume.";
} // namespace job_dialogs

namespace job_panels {
inline constexpr char update_cpu[] = "update (CPU)";
inline constexpr char whole_frame[] = "whole frame";
inline constexpr char budget_ms[] = "Budget, ms";
inline constexpr char about_budget[] =
    "The time that 99% of the frames (p99) must not exceed: 0.01 to 1,000 milliseconds. A frame at 60 Hz has 16.7.";
inline constexpr char measure[] = "Measure";
inline constexpr char about_measure[] =
    "Update: CPU time of refinement and streaming. Whole frame: with upload and drawing, in a picture as large as the "
    "profile says; slower, and dependent on the graphics driver.";
inline constexpr char frames[] = "Frames, 0: auto";
inline constexpr char about_frames[] =
    "Frames of a flight, 10 to 100,000; 0: as many as the path has at 60 Hz, or 840 for an orbit if there is no path. "
    "Fewer frames fly the same path faster, with more changes in each.";
inline constexpr char threshold_range[] = "From, to, px";
inline constexpr char about_smallest[] = "The smallest threshold to try, in pixels.";
inline constexpr char about_largest[] = "The largest threshold, in pixels: the search begins there.";
inline constexpr char use_threshold[] = "Use %.3g px";
inline constexpr char about_use_threshold[] = "Sets the threshold of the profile; one undo step.";
inline constexpr char start[] = "Start";
inline constexpr char about_start[] =
    "Flies again and again until the smallest threshold is found whose p99 keeps the budget.";
inline constexpr char csv[] = "CSV";
inline constexpr char csv_hint[] = "a file";
inline constexpr char about_csv[] = "One line for each frame, with the columns of fjell-fly --csv.";
inline constexpr char about_benchmark_frames[] = "0: as many as the path has at 60 Hz, or 840 for an orbit if there is "
                                                 "no path. Fewer frames fly the same path faster.";
inline constexpr char about_flight[] =
    "Flies %s as the profile says, over a terrain that is loaded once more for this, in a view of %u x %u.";
inline constexpr char run[] = "Run";
inline constexpr char about_run[] = "Starts at once and flies as fast as possible.";
} // namespace job_panels

namespace levels {
inline constexpr char level_bar[] = "level %u: %s triangles with legs of %.4g m";
inline constexpr char heading[] = "Triangles drawn, by level";
inline constexpr char about_levels[] =
    "Level 0: the two base triangles of a tile; each further level halves them. Legs are a triangle's two equal sides.";
inline constexpr char colour_picture[] = "Colour the picture by level";
inline constexpr char about_colour_picture[] = "Every triangle in its level's colour, as here. Costs almost nothing.";
} // namespace levels

namespace menu {
inline constexpr char open_recent[] = "Open recent";
inline constexpr char bake_heights[] = "Bake heights...";
inline constexpr char save_profile_as[] = "Save profile as...";
inline constexpr char compare_profiles[] = "Compare profiles...";
inline constexpr char save_camera_path_as[] = "Save camera path as...";
inline constexpr char export_gltf[] = "Export glTF...";
inline constexpr char screenshot[] = "Screenshot...";
inline constexpr char quit[] = "Quit";
inline constexpr char undo[] = "Undo %s###undo";
inline constexpr char redo[] = "Redo %s###redo";
inline constexpr char reset_all_values[] = "Reset all values";
inline constexpr char lower_threshold[] = "Lower threshold";
inline constexpr char raise_threshold[] = "Raise threshold";
inline constexpr char follow_the_path[] = "Follow the path";
inline constexpr char look_at_the_whole_terrain[] = "Look at the whole terrain";
inline constexpr char freeze_refinement[] = "Freeze refinement";
inline constexpr char record_a_path[] = "Record a path";
inline constexpr char add_a_point[] = "Add a point";
inline constexpr char play_the_path[] = "Play the path";
inline constexpr char panels[] = "Panels";
inline constexpr char floating_panels[] = "Floating panels";
inline constexpr char columns[] = "Columns";
inline constexpr char left_column[] = "Left column";
inline constexpr char right_column[] = "Right column, in wide windows";
inline constexpr char wider[] = "Wider";
inline constexpr char narrower[] = "Narrower";
inline constexpr char upper_panel_taller[] = "Upper panel taller";
inline constexpr char upper_panel_shorter[] = "Upper panel shorter";
inline constexpr char folded[] = "Folded";
inline constexpr char cancel_the_job[] = "Cancel the job";
inline constexpr char picture_only[] = "Picture only";
inline constexpr char keyboard_in_panels[] = "Keyboard in the panels";
inline constexpr char half_resolution_while_moving[] = "Half resolution while moving";
inline constexpr char probe_the_ground[] = "Probe the ground";
inline constexpr char pause_graphs_and_times[] = "Pause graphs and times";
inline constexpr char profile_file[] = "The profile: %.500s%s";
inline constexpr char profile_without_file[] = "the defaults, not saved to a file yet";
inline constexpr char profile_is_unsaved[] = "\nIt has unsaved changes; click to save them.";
inline constexpr char edit[] = "Edit";
inline constexpr char tools[] = "Tools";
inline constexpr char help[] = "Help";
} // namespace menu

namespace overview {
inline constexpr char overview[] = "Overview";
inline constexpr char about_overview[] = "Click, or drag, to fly there at the same height above the ground. Yellow: "
                                         "the camera; blue: the frozen camera; pink: the path.";
} // namespace overview

namespace panels {
inline constexpr char tune[] = "Tune";
inline constexpr char pictures[] = "Pictures";
inline constexpr char time[] = "Time";
inline constexpr char budgets[] = "Budgets";
inline constexpr char about_tab[] = "Drag it onto the picture, or click it twice, and the panel floats there. "
                                    "Ctrl+Page Up and Page Down turn to the panels beside it.";
inline constexpr char about_folded_strip[] = "Click to unfold the panels (Tab shows and hides them all).";
inline constexpr char about_strip[] = "Drag to resize the panels, click to fold them (Tab shows and hides them all).";
inline constexpr char about_split[] = "Drag to divide the column.";
inline constexpr char left_below[] = "left, below";
inline constexpr char right_below[] = "right, below";
} // namespace panels

namespace path {
inline constexpr char not_saved_yet[] = "not saved yet";
inline constexpr char no_path[] = "None. Record a flight, add points one by one, or open a file.";
inline constexpr char as_in_the_file[] = "as in the file; an edit converts it to these points";
inline constexpr char play[] = "Play";
inline constexpr char about_play[] = "Flies along the path, or pauses (P).";
inline constexpr char restart[] = "Restart";
inline constexpr char about_restart[] = "Plays from the beginning.";
inline constexpr char record[] = "Record";
inline constexpr char about_record[] = "Records the flight as points, which then become the path (R).";
inline constexpr char about_position[] = "Position along the path; drag to move along it.";
inline constexpr char duration[] = "Duration";
inline constexpr char about_duration[] =
    "Duration of the flight in seconds, 1 to 3,600; the points' times are stretched to it. 0: no times, and a duration "
    "chosen from the terrain's size. Enter applies it.";
inline constexpr char loop[] = "Loop";
inline constexpr char about_loop[] = "Starts again at the end.";
inline constexpr char about_point[] = "Selects this point, and looks from there.";
inline constexpr char about_add[] =
    "Adds a point where the camera is, after the selected point, or else as the last one (N).";
inline constexpr char replace[] = "Replace";
inline constexpr char about_replace[] = "Puts the selected point where the camera is.";
inline constexpr char about_remove[] = "Removes the selected point.";
inline constexpr char about_up[] = "Swaps the selected point with the one before it.";
inline constexpr char down[] = "Down";
inline constexpr char about_down[] = "Swaps the selected point with the one after it.";
inline constexpr char turntable[] = "Turntable";
inline constexpr char about_turntable[] = "Makes another path: once around what the camera looks at.";
inline constexpr char about_open[] = "Opens a camera path.";
inline constexpr char save_dots[] = "Save...";
inline constexpr char about_save[] = "Saves the camera path to a file, as control points in metres.";
inline constexpr char clear[] = "Clear";
inline constexpr char about_clear[] = "Removes the path; Restore brings it back.";
inline constexpr char about_restore[] = "Brings back the path as it was before its last change.";
} // namespace path

namespace path_points {
inline constexpr char closed[] = "Closed";
inline constexpr char about_closed[] =
    "Leads back to the first point, and on from there without a jump in position, direction or speed.";
inline constexpr char insert[] = "Insert";
inline constexpr char about_insert[] = "Adds a point on the path, where it is being played (Insert).";
inline constexpr char constant[] = "Constant";
inline constexpr char about_constant[] =
    "Sets the points' times so that the speed is the same all along; the duration stays.";
inline constexpr char ease[] = "Ease";
inline constexpr char about_ease[] =
    "Sets the points' times so that the flight begins and ends at rest; the duration stays.";
inline constexpr char target[] = "Look at";
inline constexpr char all[] = "From all";
inline constexpr char about_all[] = "The camera looks at a target all along: the middle between the probe's two marks, "
                                    "the one mark, or else the terrain's middle.";
inline constexpr char selected[] = "From selected";
inline constexpr char about_selected[] =
    "The camera looks at that target from the selected point, and along a stretch if both its points have the same.";
inline constexpr char none[] = "Nothing";
inline constexpr char about_none[] =
    "Takes the target from the selected point, or from all points if none is selected.";
} // namespace path_points

namespace hands {
inline constexpr char point_drag[] =
    "Point %zu. Drag: move it level; with Shift: up and down. Click twice: look from there. Delete: remove it.";
inline constexpr char map_point_drag[] =
    "Point %zu. Drag: move it at the same height above the ground. Click: select it; twice: look from there.";
inline constexpr char point_keys[] = "Insert  Delete";
inline constexpr char about_point_keys[] = "add a point where the path is being played; remove the selected point";
} // namespace hands

namespace picture {
inline constexpr char shaded[] = "Shaded";
inline constexpr char about_shaded[] = "Colours and light, as in a game.";
inline constexpr char wire[] = "Wire";
inline constexpr char about_wire[] = "Shaded, with the edges of all triangles.";
inline constexpr char about_levels[] =
    "Every triangle in its level's colour: coarse ones violet and blue, fine ones orange and red.";
inline constexpr char tiles[] = "Tiles";
inline constexpr char about_tiles[] = "Every tile in a colour different from its neighbours.";
inline constexpr char mips[] = "Mips";
inline constexpr char about_mips[] =
    "Coloured by the mip that is drawn: the pack's finest is red, the smallest violet. Black: not loaded yet.";
inline constexpr char residency[] = "Residency";
inline constexpr char about_residency[] = "Coloured by the finest geometry in memory, whether it is drawn or not.";
inline constexpr char about_distance[] = "White at the near plane, black beyond the terrain; logarithmic.";
inline constexpr char wireframe[] = "Wireframe";
inline constexpr char about_wireframe[] = "Edges of all triangles.";
inline constexpr char tile_borders[] = "Tile borders";
inline constexpr char about_tile_borders[] = "Borders of tiles, on the ground and in the overview.";
inline constexpr char page_borders[] = "Page borders";
inline constexpr char about_page_borders[] = "Borders of pages, which are loaded and evicted as a whole.";
inline constexpr char bounding_spheres[] = "Bounding spheres";
inline constexpr char about_bounding_spheres[] = "Around vertices, as refinement uses them.";
inline constexpr char culled[] = "Culled";
inline constexpr char about_culled[] = "With refinement frozen: culled tiles, and the frustum of the frozen camera.";
inline constexpr char true_error[] = "True error";
inline constexpr char about_true_error[] =
    "How far the mesh is from the full-resolution terrain, in pixels; hatched where it exceeds the bound. Takes the "
    "picture's place; all heights are read first.";
inline constexpr char about_camera_path[] =
    "The path, its points and the recording in progress; hidden during playback.";
inline constexpr char contours[] = "Contours";
inline constexpr char about_contours[] = "Lines of equal height, every fifth one wider.";
inline constexpr char about_slope[] = "Steep ground in bands that begin at 15, 25, 35 and 45 degrees.";
inline constexpr char no_maps[] = "This pack has no maps.";
inline constexpr char bound[] = "%.3g px: the bound";
inline constexpr char above_bound[] = "hatched: above the bound";
inline constexpr char no_reference[] = "nothing to compare with";
inline constexpr char contour_key[] = "Contours every %.4g m, wider every %.4g m.";
inline constexpr char slope_key[] = "Slope, degrees:";
inline constexpr char from_degrees[] = "from %d";
inline constexpr char and_steeper[] = "%d and steeper";
inline constexpr char culled_is_out_of_view[] =
    "Culled tiles are out of view: freeze refinement (F), and look from elsewhere.";
inline constexpr char heights_failed[] = "The heights to compare with cannot be read; see Help > Messages.";
inline constexpr char reading_heights[] = "Reading heights: %.0f%%";
inline constexpr char true_error_key[] = "True error:";
inline constexpr char interface[] = "Interface";
inline constexpr char about_interface[] = "Size of text and controls.";
inline constexpr char mode_heading[] = "Picture mode (M: next)";
inline constexpr char overlays[] = "Overlays";
} // namespace picture

namespace pictures {
inline constexpr char about_bookmark[] = "Looks from there.";
inline constexpr char about_remove[] = "Removes this bookmark.";
inline constexpr char bookmarks[] = "Bookmarks";
inline constexpr char name_hint[] = "a name, or none";
inline constexpr char about_name[] = "What the bookmark is called; without a name it is numbered.";
inline constexpr char about_add[] = "Keeps the camera's place, with a thumbnail.";
inline constexpr char none_yet[] = "This terrain has none yet.";
inline constexpr char this_view[] = "this view";
inline constexpr char the_path_frame_by_frame[] = "the path, frame by frame";
inline constexpr char render[] = "Render";
inline constexpr char frames_suffix[] = "-frames";
inline constexpr char what[] = "What";
inline constexpr char about_what[] =
    "A picture of what the camera sees, of any size; or one for each frame of the camera path.";
inline constexpr char folder[] = "Folder";
inline constexpr char folder_hint[] = "a folder";
inline constexpr char about_folder[] = "The pictures are written there: frame_00000.png and so on.";
inline constexpr char width_px[] = "Width, px";
inline constexpr char about_size[] = "Of the picture; the window's size does not matter.";
inline constexpr char height_px[] = "Height, px";
inline constexpr char rate[] = "Pictures per second";
inline constexpr char about_rate[] = "Of the flight along the path: 1 to 240.";
inline constexpr char length[] = "%s pictures for %.1f s of flight";
inline constexpr char about_render[] =
    "Draws beside the frames, and holds the threshold in every picture whatever the budgets are. A picture wider than "
    "the profile's view is refined further, as for a larger screen.";
} // namespace pictures

namespace probe {
inline constexpr char place[] = "Place";
inline constexpr char away[] = "%.20s m away";
inline constexpr char sample_place[] = "%d, %d: tile %u, %u, page %u";
inline constexpr char sample[] = "Sample";
inline constexpr char full_resolution[] = "full resolution";
inline constexpr char pages_missing[] = "within %.3g m: pages missing";
inline constexpr char ground[] = "Ground";
inline constexpr char nothing_drawn[] = "nothing is drawn here";
inline constexpr char mesh_place[] = "level %d, off by %.2f m: %.2f px";
inline constexpr char down[] = "down";
inline constexpr char up[] = "up";
inline constexpr char between_marks[] = "1 to 2";
inline constexpr char height_range[] = "%.20s to %.20s m";
inline constexpr char no_ground[] = "no ground here";
inline constexpr char point_somewhere[] = "move the pointer over the ground";
inline constexpr char click_second[] = "Click: the second place. Esc or I: end.";
inline constexpr char click_first[] = "Click: mark a place, then another. Esc or I: end.";
} // namespace probe

namespace runs {
inline constexpr char share_of_path[] = "%.0f%% of the path";
inline constexpr char unbounded[] = "%.24s: unbounded";
inline constexpr char hand_help[] = "click: look from there";
inline constexpr char summary[] =
    "%s at %.3g px: %s frames, %.1f%% of them converged; %s vertices; p99 of the error %.3g px";
inline constexpr char update_ms[] = "update, ms";
inline constexpr char about_forget[] = "Removes this run from the panel; its CSV stays.";
inline constexpr char budget_spent[] = "  budget spent";
inline constexpr char about_place[] =
    "How far along the path, the update's time, and the largest error there. Click: look from there.";
inline constexpr char slowest_places[] = "Slowest places";
inline constexpr char places_beyond_the_threshold[] = "Places beyond the threshold";
inline constexpr char nothing[] = "nothing";
inline constexpr char time[] = "time";
inline constexpr char error[] = "error";
inline constexpr char overview_colour[] = "Path on the overview coloured by";
inline constexpr char about_overview_colour[] =
    "Colours the latest run's path on the overview in the Camera panel: blue is fast or exact, red the run's p99 time "
    "or its threshold, white beyond that.";
inline constexpr char runs[] = "Runs";
inline constexpr char budget_mark[] = "red below: a budget is spent";
} // namespace runs

namespace status {
inline constexpr char about_threshold[] = "The threshold that the mesh keeps now, and why it is not the requested one.";
inline constexpr char vertices_exhausted[] = "vertices exhausted";
inline constexpr char triangles_exhausted[] = "triangles exhausted";
inline constexpr char indices_exhausted[] = "indices exhausted";
inline constexpr char page_slots_exhausted[] = "page slots exhausted";
inline constexpr char pages_missing[] = "pages missing";
inline constexpr char items_exhausted[] = "lags: work items exhausted";
inline constexpr char time_exhausted[] = "lags: time exhausted";
inline constexpr char morphing[] = "morphing";
inline constexpr char error_unbounded[] = "error unbounded, %s";
inline constexpr char within[] = "within %.4g px%s%s";
inline constexpr char about_streaming[] = "Whether everything that the view needs is loaded.";
inline constexpr char streaming_complete[] = "streaming: complete";
inline constexpr char streaming_wanted_in_flight[] = "streaming: %.12s wanted, %.12s in flight";
inline constexpr char no_terrain_is_open[] = "no terrain is open";
inline constexpr char about_no_terrain[] = "Use File > Open, or drop a file here.";
inline constexpr char about_update[] = "The longest of the last 512 updates, without the slowest hundredth.";
inline constexpr char update[] = "update p99 %s ms";
inline constexpr char about_fps[] = "Frames per second, from the median frame time.";
inline constexpr char about_triangles[] = "Triangles drawn in this frame.";
inline constexpr char triangles[] = "%s triangles";
} // namespace status

namespace streaming {
inline constexpr char all_in_memory[] =
    "The whole terrain is in memory: all of its %s pages were read when it was opened.";
inline constexpr char how_to_stream[] =
    "To stream it, give the profile fewer page slots than the pack has pages (stream.page_slots in the Tune panel), "
    "and at least one for each tile. Pages are then read when the view wants them.";
inline constexpr char stream_with[] = "Stream with %s page slots";
inline constexpr char about_stream_with[] =
    "Half of its pages. The pack is reopened and the view stays; Undo reverts it.";
inline constexpr char geometry[] = "Geometry";
inline constexpr char pages_for_this_view[] = "Pages for this view";
inline constexpr char complete[] = "complete";
inline constexpr char incomplete[] = "incomplete";
inline constexpr char about_pages_for_this_view[] = "Complete: the threshold holds against the whole terrain.";
inline constexpr char wanted_missing[] = "Wanted, missing";
inline constexpr char about_wanted[] =
    "Pages that the views want and that are not loaded, although the coarser ones above them are.";
inline constexpr char accepted[] = "Accepted, left";
inline constexpr char about_accepted[] =
    "Arrived pages that were accepted in this frame, and those left for the next ones (stream.pages).";
inline constexpr char evicting[] = "Evicting";
inline constexpr char about_evicting[] =
    "Pages that are not wanted any more, evicted as soon as the mesh does not use them.";
inline constexpr char of[] = "%s of %s";
inline constexpr char missing_error[] = "Missing error";
inline constexpr char about_missing_error[] = "The largest error on screen that a missing page may hide, in pixels.";
inline constexpr char maps[] = "Maps";
inline constexpr char mips_for_this_view[] = "Mips for this view";
inline constexpr char about_mips_for_this_view[] = "Complete: loaded and faded in.";
inline constexpr char missing_mips[] = "Missing mips";
inline constexpr char about_missing_mips[] = "Mips that the blurriest tile in view lacks.";
inline constexpr char on_the_gpu[] = "On the GPU";
inline constexpr char reading[] = "Reading";
inline constexpr char in_flight[] = "In flight";
inline constexpr char about_in_flight[] =
    "Pages and mips that were requested and have not arrived (stream.page_requests, stream.map_requests).";
inline constexpr char pages_mips[] = "Pages, mips";
inline constexpr char bytes[] = "Bytes";
inline constexpr char about_bytes[] = "Compressed, in total.";
inline constexpr char reads[] = "Reads";
inline constexpr char read_rate[] = "Read rate";
inline constexpr char about_read_rate[] = "Over the time that the reader's thread spent reading.";
inline constexpr char decompression[] = "Decompression";
inline constexpr char about_decompression[] = "Checking and decompressing on the reader's thread, in total.";
inline constexpr char withdrawn[] = "Withdrawn";
inline constexpr char about_withdrawn[] = "Requests that were not wanted any more when their turn came.";
inline constexpr char failed[] = "Failed";
inline constexpr char about_failed[] =
    "Pages and mips that are unreadable or damaged; the terrain is coarser there. See Help > Messages.";
inline constexpr char started[] = "coarse terrain loaded";
inline constexpr char starting[] = "loading coarse terrain";
inline constexpr char about_started[] = "Whether the coarsest page and the smallest mips of every tile are loaded.";
inline constexpr char pages_mips_unit[] = "pages, mips";
inline constexpr char wanted[] = "wanted";
inline constexpr char in_flight_line[] = "in flight";
} // namespace streaming

namespace time {
inline constexpr char frame_at_60_hz[] = "16.7 ms: 60 Hz";
inline constexpr char about_upload[] = "Giving the driver what has changed in the mesh.";
inline constexpr char about_draw[] = "Giving the driver the terrain to draw.";
inline constexpr char about_present[] =
    "Copying the picture, drawing the panels, swapping buffers. The GPU, or the software renderer, catches up here "
    "with what it was given; with vertical sync the frame waits here.";
inline constexpr char about_other[] = "Input, the overview, and rebuilding.";
inline constexpr char last[] = "last";
inline constexpr char frame[] = "Frame";
inline constexpr char about_frame[] =
    "All that the editor does for a frame whose terrain has changed. Waiting for input does not count.";
inline constexpr char update[] = "Update";
inline constexpr char about_update[] = "The method's update on the CPU.";
inline constexpr char prepare[] = "  prepare";
inline constexpr char about_prepare[] = "Part of the update: views, arrived pages, and which groups have work.";
inline constexpr char refine[] = "  refine";
inline constexpr char about_refine[] = "Part of the update: evaluating, activating and deactivating vertices.";
inline constexpr char output[] = "  output";
inline constexpr char about_output[] = "Part of the update: writing triangles and draw ranges.";
inline constexpr char about_stream[] = "Accepting arrived pages and mips, and requesting others.";
inline constexpr char upload[] = "Upload";
inline constexpr char draw[] = "Draw";
inline constexpr char present[] = "Present";
inline constexpr char editor[] = "Editor";
inline constexpr char about_editor[] = "The editor's own code: panels, commands and measures. Should stay below 1 ms.";
inline constexpr char other[] = "Other";
inline constexpr char gpu[] = "GPU";
inline constexpr char about_gpu[] =
    "What the GPU took by its own clock, some frames ago: beside the CPU, so it is none of the parts above.";
inline constexpr char no_gpu[] = "GPU: not measured; software draws, in Present.";
inline constexpr char update_part[] = "update";
inline constexpr char about_update_part[] = "The method's update on the CPU, and streaming.";
inline constexpr char upload_part[] = "upload";
inline constexpr char draw_part[] = "draw";
inline constexpr char present_part[] = "present";
inline constexpr char editor_part[] = "editor";
inline constexpr char about_editor_part[] = "The editor's own code.";
inline constexpr char other_part[] = "other";
inline constexpr char mean_of_frames[] = "Frame, mean of %zu";
inline constexpr char this_frame[] = "This frame";
inline constexpr char before_the_newest[] = "Before the newest";
inline constexpr char frames[] = "%s frames";
inline constexpr char threshold[] = "Threshold";
inline constexpr char threshold_of[] = "%.3g px of %.3g";
inline constexpr char changes[] = "Activated, deactivated";
inline constexpr char triangles_drawn[] = "Triangles drawn";
inline constexpr char uploaded[] = "Uploaded";
inline constexpr char go_to_its_camera[] = "Go to its camera";
inline constexpr char about_go_to_its_camera[] = "Puts the camera where this frame was drawn from.";
inline constexpr char all_frames[] = "All frames";
inline constexpr char about_all_frames[] = "Shows the mean of all measured frames again.";
inline constexpr char continue_[] = "Continue###hold";
inline constexpr char pause[] = "Pause###hold";
inline constexpr char about_continue[] = "Measures all frames again (T).";
inline constexpr char about_pause[] = "Holds graphs and times still, to be looked at (T).";
inline constexpr char zoom_out[] = "Zoom out";
inline constexpr char zoom_in[] = "Zoom in";
inline constexpr char about_zoom_in[] =
    "Pauses, and shows half as many frames, around the chosen one. Or drag over a graph.";
inline constexpr char about_older[] = "The report of the frame before it.";
inline constexpr char about_newer[] = "The report of the frame after it.";
inline constexpr char about_zoom_out[] = "Shows all frames again. Drag over a graph to zoom in.";
inline constexpr char paused[] = "paused";
inline constexpr char nothing_measured[] = "No frame has been measured yet: fly. A still view costs nothing.";
inline constexpr char frame_part[] = "frame";
inline constexpr char effective[] = "effective";
inline constexpr char requested[] = "requested";
inline constexpr char changes_per_frame[] = "Changes per frame";
inline constexpr char activated[] = "activated";
inline constexpr char deactivated[] = "deactivated";
inline constexpr char mesh[] = "mesh";
} // namespace time

namespace timeline {
inline constexpr char speed_up_to[] = "speed, up to %s";
inline constexpr char point[] = "point %zu: %.2f s";
inline constexpr char stretch[] = "from point %zu: %s on average";
inline constexpr char about_playhead[] =
    "%.1f s: %s. Click or drag: go there. Click twice on the lower edge: a new point there.";
inline constexpr char about_first_point[] = "Point %zu, where times begin. Click: select it; twice: look from there.";
inline constexpr char about_point[] =
    "Point %zu at %.2f s. Drag: another time, between its neighbours'; with Shift without snapping to the lines and "
    "the playhead. Click: select it; twice: look from there. Keys: left and right select a point, with Shift they "
    "move it, with Ctrl by a whole second; Enter: look from there; Delete: remove it.";
inline constexpr char about_speed[] = "%s; %s on average from point %zu to %zu. Drag up or down: faster or slower "
                                      "there; the times of the points after it follow. Keys: Shift with up and down.";
} // namespace timeline

namespace tune {
inline constexpr char about_next_frame[] = "A change takes effect in the next frame.";
inline constexpr char about_method_memory[] = "A change reallocates the method's memory.";
inline constexpr char about_reopening[] = "A change reopens the pack; the view stays.";
inline constexpr char range[] = "Range: %.10g to %.10g%s%s\n";
inline constexpr char about_shown_ms[] = "Shown in milliseconds; a profile's file has microseconds.\n";
inline constexpr char not_used_now[] = "\n\nNot used now: ";
inline constexpr char reset[] = "reset";
inline constexpr char about_reset[] = "Reset to the saved value: %s";
inline constexpr char on[] = "on";
inline constexpr char compared[] = "compared: %s";
} // namespace tune

namespace tune_cost {
inline constexpr char gpu[] = " GPU";
inline constexpr char used[] = ", used ";
inline constexpr char peak[] = ", peak ";
inline constexpr char gpu_used[] = " GPU, used ";
inline constexpr char last_frame[] = "last frame ";
inline constexpr char last_update[] = "last update %s ms";
inline constexpr char keeps_px[] = "keeps %.*f px";
inline constexpr char triangles_drawn[] = " triangles drawn";
inline constexpr char the_pack_has[] = ", the pack has ";
inline constexpr char in_flight_with_mips[] = ", in flight %u with mips";
inline constexpr char up_to[] = "up to ";
inline constexpr char last_frame_left[] = "last frame %u, left %u";
inline constexpr char incremental_only[] = "for the incremental method only.";
inline constexpr char recursive_only[] = "for the recursive method only.";
inline constexpr char streaming_only[] =
    "for streaming only: a pack is streamed when it has more pages than the profile has page slots.";
inline constexpr char morph_time_only[] = "for morph \"time\" only.";
} // namespace tune_cost

namespace tune_curve {
inline constexpr char times[] = "p50 %s ms, p99 %s ms, max %s ms";
inline constexpr char flights[] = "%s vertices; %u flights of %u frames";
inline constexpr char reached[] = "%.1f%% of the frames reached the threshold";
inline constexpr char limit[] = "slowest frames: %.0f%% %s";
inline constexpr char keeps_the_budget[] = "keeps the budget";
inline constexpr char does_not_keep_the_budget[] = "does not keep the budget";
inline constexpr char no_curve_yet[] = "The curve appears here, flight by flight.";
inline constexpr char p99_axis[] = "p99, ms";
inline constexpr char p50_axis[] = "p50, ms";
inline constexpr char threshold_axis[] = "threshold, px (finer to the right)";
} // namespace tune_curve

namespace view {
inline constexpr char frozen[] = "Refinement frozen (F to release)";
inline constexpr char recording[] = "Recording: %zu points (R to stop)";
inline constexpr char playing[] = "Path: %.1f of %.1f s (P to pause)";
inline constexpr char orbiting[] = "Orbit (1 to fly)";
inline constexpr char opening[] = "Opening %.500s";
inline constexpr char no_terrain[] = "No terrain is open: use File > Open, or drop a file here";
} // namespace view

// What is not of one panel.

namespace window {
inline constexpr char program[] = "Fjell editor";
inline constexpr char default_profile[] = "default profile";
} // namespace window

namespace terminal { // of a run without a window
inline constexpr char message[] = "fjell-editor: {}\n";
inline constexpr char baking[] = "fjell-editor: baking {}: {} {:.0f}%\n";
} // namespace terminal

namespace steps { // that Undo and Redo name
inline constexpr char several_values[] = "several values";
inline constexpr char camera_path[] = "camera path";
} // namespace steps

namespace numbers {
inline constexpr char place[] = "%.20s E  %.20s S  %.20s m";
} // namespace numbers

// Where a field, an option of fjell-bake in its messages, is named by the dialog that bakes.
namespace bake_words {
inline constexpr char the_spacing[] = "the spacing";
inline constexpr char hole[] = "\"hole\" for No data";
inline constexpr char fill[] = "\"fill\"";
inline constexpr char no_voids[] = "\"none\" for Voids";
inline constexpr char the_height_scale[] = "the height scale";
inline constexpr char their_encoding[] = "their encoding (More options)";
inline constexpr char spacing_of_name[] = "as the file's name says";
inline constexpr char spacing_of_slopes[] = "with which slopes are those of mountains; change it if you know better";
inline constexpr char image[] = "{} x {} pixels, {}";
inline constexpr char colour[] = "colour";
inline constexpr char grey[] = "grey";
inline constexpr char unreadable_image[] = "{}: cannot be read{}";
} // namespace bake_words

// What a file should have been, in the baker's messages.
namespace kinds {
inline constexpr char height_field[] = "a height field";
inline constexpr char image[] = "an image";
inline constexpr char height_field_or_image[] = "a height field or an image";
} // namespace kinds

// What limits a tuning.
namespace limits {
inline constexpr char preparing_views[] = "preparing views";
inline constexpr char refining[] = "refining";
inline constexpr char writing_triangles[] = "writing triangles";
inline constexpr char streaming[] = "streaming";
inline constexpr char uploading[] = "uploading";
inline constexpr char drawing[] = "drawing";
} // namespace limits

// What a job has made, or how it ended.
namespace results {
inline constexpr char an_orbit[] = "an orbit";
inline constexpr char the_path[] = "the camera path";
inline constexpr char path_file[] = "the path %.80s";
inline constexpr char cancelled[] = "{} cancelled{}{}";
inline constexpr char baked[] = "{}: {} x {} samples, {} x {} tiles of {} cells, {} in {:.1f} s{}";
inline constexpr char baked_resumed[] = ", resumed from an earlier bake";
inline constexpr char bake_can_resume[] = "{} remains: the same bake resumes from it; or delete it";
inline constexpr char no_files_remain[] = "no files remain";
inline constexpr char exported[] = "{}{} vertices, {} triangles, {} within {:.3g} px{}";
inline constexpr char export_would_have[] = "the export has ";
inline constexpr char export_not_as_asked[] = ", which is not what was asked for";
inline constexpr char benchmark[] = "{}: {} frames, {} of them converged; update p50 {} ms, p99 {} ms";
inline constexpr char picture[] = "{}: {} pixels";
inline constexpr char pictures[] = "{}: {} pictures of {} pixels; a film of them: ffmpeg -framerate {:g} -i "
                                   "\"{}/frame_%05d.png\" -pix_fmt yuv420p film.mp4";
inline constexpr char tuned[] = "{:.3g} px{} over {}: p99 {} ms of {} ms{}{}; {} flights";
inline constexpr char tuned_least[] = ", the smallest allowed,";
inline constexpr char tuned_limit[] = ", limited by {} ({:.0f}% of the slowest frames' time)";
inline constexpr char tuned_mostly[] = ", mostly for {} ({:.0f}% of the slowest frames' time)";
inline constexpr char tuned_budget_limits[] = "; below it a budget of the profile is the limit, not time";
inline constexpr char nothing_flown[] = "no flight was made";
inline constexpr char not_tuned[] = "no threshold up to {:.3g} px keeps the budget over {}; there {}; {} flights";
inline constexpr char raise_budgets[] =
    "{:.0f}% of the frames reached it: raise vertices, triangles, work items or page slots";
inline constexpr char takes_longer[] = "p99 {} ms of {} ms{}: {}";
inline constexpr char smaller_picture[] = "choose a smaller picture, or a larger budget";
inline constexpr char fewer_items[] = "choose a slower path, fewer work items, or a larger budget";
} // namespace results

// What the status line tells without having been asked.
namespace notices {
inline constexpr char driver_reset[] = "the graphics driver was reset; all GPU resources were recreated";
inline constexpr char file_changed[] = "{}: the file has changed; its new contents are shown";
inline constexpr char unreadable_pages[] =
    "{}: {} pages or mips cannot be read; the terrain is coarser there; check the pack with fjell-bake verify";
inline constexpr char reverted[] = "the change was reverted: ";
inline constexpr char out_of_range[] = "{}: {}; set to {}";
inline constexpr char sample_baked_again[] = "the sample is baked again: {}";
inline constexpr char profile_opened[] = "opened {}";
inline constexpr char profile_saved[] = "saved {}";
inline constexpr char path_saved[] = "saved the camera path to {}";
inline constexpr char path_replaced[] = "the previous path was not saved; Restore brings it back";
inline constexpr char path_cleared[] = "the cleared path was not saved; Restore brings it back";
inline constexpr char path_recovered[] = "the unsaved camera path was written to {}";
inline constexpr char recovered_file[] = "Recovered.";
inline constexpr char recording_full[] = "the recording is full and has stopped; record the rest as another path";
inline constexpr char bookmark_name[] = "Place {}";
inline constexpr char bookmarks_unreadable[] =
    "{}: the bookmarks cannot be read ({}); move the file away to keep new ones";
inline constexpr char settings_not_saved[] = "settings cannot be saved: {}";
inline constexpr char settings_damaged[] = "{}: {} cannot be understood; the default is taken";
inline constexpr char settings_kept[] = "{}; the file will be kept as {}.damaged";
inline constexpr char recovery_damaged[] = "{}: damaged recovery file of an earlier run; kept as {}.damaged";
inline constexpr char recovery_off[] = "changes would not survive a crash; save often: {}";
inline constexpr char folder_unreadable[] = "cannot be read: {}";
} // namespace notices

// Why a command is not carried out, and what to do about it.
namespace refusals {
inline constexpr char no_terrain[] = "no terrain is open; open a pack first";
inline constexpr char path_needs_terrain[] = "{}: this is a camera path; open a terrain for it first";
inline constexpr char opening_abandoned[] = "{}: is no longer being opened";
inline constexpr char no_such_file[] = "{}: there is no such file";
inline constexpr char is_folder[] = "{}: this is a folder; open a file in it";
inline constexpr char not_a_file[] = "{}: not a file";
inline constexpr char json_too_long[] = "{}: too long for a camera path or a recipe";
inline constexpr char unknown_json[] =
    "{}: JSON, but no camera path (points, orbit, straight), landscape (relief_m) or recipe (inputs)";
inline constexpr char unknown_kind[] = "{}: neither a pack, a profile, a camera path nor heights that GDAL opens";
inline constexpr char not_settings[] = "{}: no settings";

inline constexpr char no_key[] = "{}: no such key; a saved profile lists them all";
inline constexpr char profile_without_file[] = "the profile has no file yet; say where to save it";
inline constexpr char no_profile_to_compare[] =
    "there is no profile to compare with; choose one with File > Compare profiles first";

inline constexpr char no_question[] = "there is no question to answer";
inline constexpr char nothing_to_recover[] = "there is nothing to recover";
inline constexpr char no_recovery_headless[] = "a headless run keeps nothing; recover in the editor's window";
inline constexpr char no_recovery_file[] = "{}: cannot write there; choose another XDG_STATE_HOME";

inline constexpr char no_sample_folder[] = "there is no folder for the sample; set XDG_CACHE_HOME or HOME";
inline constexpr char no_heights[] = "choose a file of heights to bake";
inline constexpr char bad_word[] = "{}={}: must be one of {}";
inline constexpr char bad_spacing[] = "spacing={}: must be 0 or more (metres)";
inline constexpr char bad_memory[] = "memory_mb={}: must be 128 to {}";
inline constexpr char pack_is_folder[] = "the pack's name is that of a folder; give a name in it";
inline constexpr char no_pack_folder[] = "{} does not exist; choose another folder for the pack";
inline constexpr char pack_folder_read_only[] = "nothing may be written to {}; choose another folder for the pack";
inline constexpr char pack_exists[] =
    "{}: exists already; open that pack, or bake elsewhere: --do \"bake {} OTHER.fjell\"";
inline constexpr char no_baked_pack[] = "no pack is waiting to be opened";

inline constexpr char another_job[] = "another job is running; wait for it, or cancel it first";
inline constexpr char no_thread[] = "cannot create a thread for the job; close other programs";
inline constexpr char unknown_failure[] = "the job failed with an unknown error; please report it with its settings";
inline constexpr char no_frame_yet[] = "no frame has been drawn yet; try again";
inline constexpr char export_without_name[] = "give the export a file name that ends in .glb";
inline constexpr char bad_threshold[] = "a threshold of {} px: must be {} to {}";
inline constexpr char csv_without_name[] = "give the CSV a file name";
inline constexpr char bad_frames[] = "frames must be 1 to 1,000,000, or 0 for the path's own";
inline constexpr char single_frame[] =
    "the path has a single frame, whose mesh is built from scratch; choose more frames";
inline constexpr char bad_tune_budget[] =
    "the budget (budget_us) is {} us: must be 10 to 1,000,000 us, which is 0.01 to 1,000 ms";
inline constexpr char bad_tune_frames[] = "frames {}: must be 10 to 100,000, or 0 for the path's own";
inline constexpr char bad_tune_range[] = "least_px {} and most_px {}: must rise, from {} to {} pixels";
inline constexpr char picture_without_name[] = "give the picture a file name, or its pictures a folder";
inline constexpr char too_many_pictures[] = "{} pictures: at most {}; choose fewer per second";
inline constexpr char no_picture_folder[] = "{}: the folder cannot be made; choose another one";
inline constexpr char picture_folder_used[] = "{}: holds pictures of a path already; choose another folder";

inline constexpr char frame_not_measured[] = "not so many frames have been measured yet; fly on";
inline constexpr char no_runs[] = "no benchmark has been flown yet; run one first";
inline constexpr char no_such_run[] = "there is no run {}; there are 0 to {}";
inline constexpr char no_bookmarks[] = "this terrain has no bookmarks yet; add one first";
inline constexpr char no_such_bookmark[] = "there is no bookmark {}; there are 0 to {}";
inline constexpr char too_many_bookmarks[] = "there are {} bookmarks already; remove some";

inline constexpr char camera_too_far[] = "the camera's position must be within 10,000 km of the terrain's first sample";
inline constexpr char no_path[] = "there is no camera path yet; open one, record one or add points";

inline constexpr char path_without_file[] = "the camera path has no file yet; say where to save it";
inline constexpr char path_without_points[] = "the camera path has no points yet; add some first";
inline constexpr char path_too_short[] = "a camera path needs at least 2 points; add some first";
inline constexpr char closed_path_too_short[] = "a closed camera path goes through at least 2 points; add some first";
inline constexpr char path_too_long[] = "the path would be longer than {} seconds; make it shorter first";
inline constexpr char too_many_points[] = "a camera path has at most {} points; remove some first";
inline constexpr char no_such_point[] = "there is no point {}; the path has 0 to {}";
inline constexpr char same_pose[] = "an adjacent point has the same pose already; move the camera first";
inline constexpr char point_there[] = "the camera path has a point there already; go to a place between two points";
inline constexpr char points_too_close[] =
    "two points would be less than {} s apart; make the path longer, or remove one";
inline constexpr char bad_duration[] =
    "a path lasts 1 to {} seconds, or 0 for a duration chosen from the terrain's size";
inline constexpr char bad_turntable_duration[] = "a turntable lasts 1 to {} seconds";
inline constexpr char nothing_recorded[] = "nothing was recorded, because the camera did not move";
inline constexpr char no_earlier_path[] = "there is no earlier camera path to restore";
inline constexpr char no_later_path[] = "there is no later camera path to restore";
inline constexpr char first_point_time[] = "the first point's time is 0; move the others, or change the duration";
inline constexpr char bad_point_time[] = "point {} can be passed from {:.3f} to {:.3f} s, between its neighbours";
inline constexpr char no_stretch[] = "no stretch begins at point {}, the last one";
inline constexpr char bad_stretch_speed[] = "a speed must be more than 0 m/s; move the points' times apart for a rest";
inline constexpr char stretch_turns_only[] = "the camera only turns on that stretch; move its points' times instead";
inline constexpr char no_targets[] = "no point of the camera path has a target";
inline constexpr char target_below_point[] =
    "a point lies straight above or below that place; choose another place to look at";
inline constexpr char camera_above_target[] =
    "the camera is straight above what it looks at; look at it from a side first";

inline constexpr char quote_not_closed[] = "a quote is not closed";
inline constexpr char no_command[] = "{}: no such command; fjell-editor --help-commands lists them";
inline constexpr char bad_command[] = "{}: {}; usage: {} {}";
inline constexpr char bad_measure[] = "{}: measure must be update or frame";
inline constexpr char bad_apply[] = "{}: apply must be yes or no";
inline constexpr char missing_word[] = "{} is missing";
inline constexpr char only_may_follow[] = "{}: only {} may follow";
inline constexpr char not_on_or_off[] = "{}: must be on or off";
inline constexpr char none_of_these[] = "{}: no such {}; choose one of {}";
inline constexpr char no_option[] = "{}: no such option; choose from {}";
inline constexpr char extra_word[] = "{}: unexpected extra word";
inline constexpr char not_a_number[] = "{}: {} must be a number";
inline constexpr char not_a_count[] = "{} must be a whole number from {} to {}";
inline constexpr char number_out_of_range[] = "{} must be a number from {} to {}";
} // namespace refusals

} // namespace fjell::editor::strings
