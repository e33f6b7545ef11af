// What a user reads in the panels, dialogs and menus of the editor: all of it, and nothing else.
//
// Each panel has a namespace, called as its source; `common` is what several say, `keys` what keys are called. Formats
// are arrays, so that compilers compare them with their arguments. Test: unit_editor, editor_strings_test.
// Elsewhere, beside what they describe: names of commands and modes (names.h), of profile keys
// (flight/profile_keys.cpp). Thread: any. Memory: none. Failure: none.
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
inline constexpr char a_png_file[] = "a file that ends in .png";
inline constexpr char where_the_png_goes[] = "Where the PNG goes.";
inline constexpr char open_more[] = "Open...";
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
inline constexpr char auto_holes_suspicious_values_refused[] = "auto: holes, suspicious values refused";
inline constexpr char use[] = "Use %.32s";
inline constexpr char what_the_line_below_says[] = "What the line below says.";
inline constexpr char browse[] = "Browse";
inline constexpr char one_more_file_beside_it[] = "One more file beside it: several make a mosaic.";
inline constexpr char more_options[] = "More options";
inline constexpr char no_data[] = "No data";
inline constexpr char samples_without_a_height_a[] =
    "Samples without a height: a hole, filled from their neighbours, or refused.";
inline constexpr char voids[] = "Voids";
inline constexpr char what_the_file_marks[] = "what the file marks";
inline constexpr char numbers_that_stand_for_no[] =
    "Numbers that stand for no height without the file saying so, such as -9999; several with commas. none: every "
    "other number is a height.";
inline constexpr char crs[] = "CRS";
inline constexpr char the_files_own_degrees_become[] = "the file's own; degrees become UTM";
inline constexpr char another_coordinate_reference_system_to[] =
    "Another coordinate reference system to reproject to, such as EPSG:25832; none: nothing is reprojected.";
inline constexpr char tile[] = "Tile";
inline constexpr char cells_along_a_side_of[] =
    "Cells along a side of a tile, the unit of drawing. Smaller tiles are culled more tightly and cost more draw "
    "calls; auto chooses 512, or what suits the extents.";
inline constexpr char order[] = "Order";
inline constexpr char order_of_vertices_in_a[] = "Order of vertices in a page: planar and hz (hierarchical Z) for both "
                                                 "methods; linear, as in the thesis, for the recursive method.";
inline constexpr char a_file_or_drop_one[] = "a file, or drop one here";
inline constexpr char geotiff_png_bmp_ascii_grid[] =
    "GeoTIFF, PNG, BMP, ASCII grid, HGT, USGS DEM, netCDF, VRT; or a recipe (.json).";
inline constexpr char pack[] = "Pack";
inline constexpr char beside_the_heights_with_fjell[] = "beside the heights, with .fjell";
inline constexpr char where_the_pack_is_written[] =
    "Where the pack is written. An existing one is replaced once you have agreed and the bake is complete.";
inline constexpr char spacing_m[] = "Spacing, m";
inline constexpr char metres_between_samples_0_the[] =
    "Metres between samples; 0: the file's own. Needed where it has no coordinates.";
inline constexpr char height_scale[] = "Height scale";
inline constexpr char multiplies_heights_0_3048_converts[] =
    "Multiplies heights: 0.3048 converts feet to metres. 1: as the file has them.";
inline constexpr char height_offset_m[] = "Height offset, m";
inline constexpr char added_to_heights_after_the[] = "Added to heights, after the scale.";
inline constexpr char texture[] = "Texture";
inline constexpr char an_ortho_image_placed_by[] =
    "An ortho-image, placed by its coordinates or stretched over the terrain.";
inline constexpr char ramp[] = "Ramp";
inline constexpr char by_height_from_meadows_to[] = "by height, from meadows to snow";
inline constexpr char colours_by_height_and_slope[] =
    "Colours by height and slope where there is no image (JSON, as in content/ramps).";
inline constexpr char rules[] = "Rules";
inline constexpr char which_materials_lie_where[] = "Rules for control maps: which materials lie where, by height, "
                                                    "slope, curvature, aspect, wetness and noise, by rasters "
                                                    "and paint (JSON, as in content/materials/control).";
inline constexpr char control_maps[] = "Control maps";
inline constexpr char texels_of_the_maps_of[] =
    "How fine the control maps of the rules are: full has a texel for each sample, half for 2 x 2, quarter for 4 x 4.";
inline constexpr char horizons[] = "Horizons";
inline constexpr char maps_for_shadows_at_any[] =
    "Horizon maps, for shadows at any time of day: half has a texel for 2 x 2 samples, quarter for 4 x 4.";
inline constexpr char rules_materials[] = "%zu, %zu materials";
inline constexpr char others[] = "others";
inline constexpr char without_a_material[] = "without a material";
inline constexpr char extract[] = "Extract";
inline constexpr char all_of_it[] = "all of it";
inline constexpr char only_what_lies_in_it[] =
    "Only what lies within west,south,east,north: units of the CRS after reprojection, or columns and rows from the "
    "north-west where there are no coordinates.";
inline constexpr char encoding[] = "Encoding";
inline constexpr char heights_in_three_colours[] =
    "How heights are packed into red, green and blue: terrarium or terrain-rgb (Mapbox). none: one band of heights.";
inline constexpr char the_ramps_colours_from_the[] = "The ramp's colours, from the lowest height to the highest.";
inline constexpr char the_heights_in_the_colours[] =
    "The heights in the colours of the ramp, and beside them the texture.";
inline constexpr char the_heights_in_the_colours_that[] =
    "The heights in the colours that the terrain will have; where rules lay materials, in the colours of the list "
    "below.";
inline constexpr char looking_at_the_heights[] = "Looking at the heights...";
inline constexpr char size_heights_and_coordinates_of[] = "Size, heights and coordinates of the file are shown here.";
inline constexpr char about[] = "about ";
inline constexpr char to_m[] = "%s%s to %s m";
inline constexpr char samples[] = "Samples";
inline constexpr char spacing[] = "Spacing";
inline constexpr char extents[] = "Extents";
inline constexpr char no_unit_is_named_1[] = "No unit is named: 1 counts as a metre";
inline constexpr char no_coordinate_reference_system[] = "No coordinate reference system";
inline constexpr char reprojected_from[] = ", reprojected from ";
inline constexpr char looking_at_the_files[] = "Looking at the files...";
inline constexpr char choose_a_file_of_heights[] = "Choose a file of heights: browse, type, or drop it on the window.";
inline constexpr char proposed[] = "%s. Proposed: %s, %s.";
inline constexpr char some_seconds[] = "some seconds";
inline constexpr char about_time[] = "about %.0f %s";
inline constexpr char seconds[] = "seconds";
inline constexpr char minutes[] = "minutes";
inline constexpr char writes_to_in_while_you[] = "Writes %s: %s to %s, in %s, while you fly on.%s %s%s%s";
inline constexpr char a_pack_of_that_name[] = " A pack of that name is there; you are asked before it is replaced.";
inline constexpr char when_it_is_done_you[] = "When it is done you are asked whether to leave ";
inline constexpr char then_it_is_opened[] = "Then it is opened.";
inline constexpr char choose_a_file[] = "Choose a file";
inline constexpr char choose[] = "Choose";
inline constexpr char bakes_in_the_background_with[] = "Bakes in the background with 512 MB of memory (Enter).";
inline constexpr char is_baked_fly_it_and[] = "%s is baked. Fly it, and leave %s?";
inline constexpr char fly_it[] = "Fly it";
inline constexpr char not_now[] = "Not now";
inline constexpr char it_stays_on_the_disk[] = "It stays on the disk: File > Open.";
} // namespace bake

namespace budgets {
inline constexpr char no_limit[] = "no limit";
inline constexpr char raise_it_with[] = "%s\nRaise it with %s.";
inline constexpr char double_[] = "Double";
inline constexpr char twice_as_much_from_the[] = "Twice as much, from the next frame on.";
inline constexpr char twice_as_much_memory_is[] = "Twice as much. Memory is reallocated; the view stays.";
inline constexpr char exhausted[] = "exhausted: %s";
inline constexpr char refinement_used_peak_limit[] = "Refinement:  used | peak | limit";
inline constexpr char slots_of_the_vertex_buffer[] = "Slots of the vertex buffer. Exhausted, the threshold rises.";
inline constexpr char indices[] = "Indices";
inline constexpr char slots_of_the_index_buffer[] = "Slots of the index buffer. Exhausted, the threshold rises.";
inline constexpr char slots_of_the_index_buffer_in[] =
    "Slots of the index buffer, in whole segments. Exhausted, the threshold rises.";
inline constexpr char vertices_that_an_update_examines[] =
    "Vertices that an update examines or changes. Exhausted, the mesh lags behind the camera.";
inline constexpr char time_us[] = "Time, us";
inline constexpr char what_an_update_may_take[] =
    "What an update may take. Exhausted, the mesh lags behind the camera.";
inline constexpr char streaming_used_peak_limit[] = "Streaming:  used | peak | limit";
inline constexpr char pages_in_memory_exhausted_distant[] =
    "Pages in memory. Exhausted, distant terrain is coarser than requested.";
inline constexpr char requests[] = "Requests";
inline constexpr char pages_and_mips_in_flight[] =
    "Pages and mips in flight (stream.map_requests for mips). Exhausted, further requests wait.";
inline constexpr char pages_per_frame[] = "Pages per frame";
inline constexpr char accepted_pages_10_to_20[] =
    "Accepted pages, 10 to 20 us each. Exhausted, some wait for the next frame.";
inline constexpr char map_memory[] = "Map memory";
inline constexpr char maps_on_the_gpu_exhausted[] =
    "Maps on the GPU. Exhausted, distant maps are blurrier than requested.";
inline constexpr char maps_uploaded_to_the_gpu[] = "Maps uploaded to the GPU; one mip may exceed it.";
inline constexpr char pages_tested[] = "Pages tested";
inline constexpr char limit_reached[] = "limit reached";
inline constexpr char within_the_limit[] = "within the limit";
inline constexpr char stream_tests_how_many_pages[] =
    "stream.tests: how many pages a stream update tests. Raise it when the limit is reached.";
inline constexpr char memory[] = "Memory";
inline constexpr char terrain[] = "Terrain";
inline constexpr char page_slots_page_table_and[] = "Page slots, page table and corners.";
inline constexpr char method[] = "Method";
inline constexpr char vertices_indices_and_bookkeeping[] = "Vertices, indices and bookkeeping.";
inline constexpr char requests_in_flight_and_their[] = "Requests in flight and their buffers.";
inline constexpr char gpu_mesh[] = "GPU: mesh";
inline constexpr char vertex_and_index_buffers_without[] = "Vertex and index buffers, without staging buffers.";
inline constexpr char gpu_maps[] = "GPU: maps";
inline constexpr char textures_of_colours_and_normals[] = "Textures of colours and normals.";
inline constexpr char host_and_gpu_without_the[] = "Host and GPU, without the program itself.";
} // namespace budgets

namespace camera {
inline constexpr char east[] = "East";
inline constexpr char metres_east_of_the_terrains[] = "Metres east of the terrain's first sample. Enter applies it.";
inline constexpr char south[] = "South";
inline constexpr char metres_south_of_the_terrains[] = "Metres south of the terrain's first sample. Enter applies it.";
inline constexpr char height[] = "Height";
inline constexpr char metres_above_zero_height_never[] =
    "Metres above zero height; never below the ground. Enter applies it.";
inline constexpr char above_ground[] = "Above ground";
inline constexpr char metres_above_the_ground_under[] = "Metres above the ground under the camera. Enter applies it.";
inline constexpr char heading[] = "Heading";
inline constexpr char degrees_clockwise_from_north_enter[] = "Degrees clockwise from north. Enter applies it.";
inline constexpr char pitch[] = "Pitch";
inline constexpr char degrees_up_from_the_horizon[] = "Degrees up from the horizon, -86 to 86. Enter applies it.";
inline constexpr char path[] = "Path";
inline constexpr char w_s_a_d_q[] = "W S A D Q E move, dragging looks, the wheel sets the speed (1).";
inline constexpr char dragging_orbits_the_ground_at[] =
    "Dragging orbits the ground at the picture's centre, the wheel zooms, right drag pans (2).";
inline constexpr char follows_the_camera_path[] = "Follows the camera path (3).";
inline constexpr char view_all[] = "View all";
inline constexpr char look_at_the_whole_terrain[] = "Look at the whole terrain from the south (Home).";
inline constexpr char speed[] = "Speed";
inline constexpr char flying_speed_in_metres_per[] =
    "Flying speed in metres per second; Shift is five times as fast. The wheel over the picture changes it too; Ctrl "
    "click to type a value.";
inline constexpr char freeze_refinement_f[] = "Freeze refinement (F)";
inline constexpr char the_mesh_stays_refined_and[] = "The mesh stays refined and culled for the current camera while "
                                                     "you look at it from elsewhere. The overview shows both cameras.";
inline constexpr char position[] = "Position";
} // namespace camera

namespace compare_picture {
inline constexpr char threshold[] = "threshold";
inline constexpr char profile[] = "profile";
inline constexpr char divider[] = "Divider";
inline constexpr char where_the_divider_stands[] =
    "Where the divider stands, in percent of the picture's width. Or drag it.";
inline constexpr char the_profile_alone[] = "The profile alone.";
inline constexpr char this_profile_at_another_threshold[] = "This profile at another threshold, in the same picture.";
inline constexpr char the_profile_chosen_to_compare[] =
    "The profile chosen with File > Compare profiles, in the same picture.";
inline constexpr char choose_a_profile_to_compare[] = "Choose a profile with File > Compare profiles first.";
inline constexpr char the_other_threshold_in_pixels[] = "The other threshold, in pixels. Enter applies it.";
inline constexpr char px_triangles[] = "%.3g px, %s triangles";
inline constexpr char px_opening[] = "%.3g px: opening";
inline constexpr char compare_in_the_picture[] = "Compare in the picture";
inline constexpr char side_by_side[] = "side by side";
inline constexpr char difference[] = "difference";
inline constexpr char on_the_left_the_profile[] =
    "On the left the profile, on the right the other one; drag the divider in the picture.";
inline constexpr char black_where_both_pictures_are[] = "Black where both pictures are alike; over blue and yellow to "
                                                        "white, which is an eighth of full brightness apart, or more.";
inline constexpr char drag_the_profile_on_the[] =
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
inline constexpr char stops_the_job_no_partial[] = "Stops the job; no partial file remains.";
inline constexpr char leaves_this_dialog_esc_a[] = "Leaves this dialog (Esc); a job that runs goes on.";
inline constexpr char m_s_s_left[] = "  %.1f M/s  %.0f s left";
inline constexpr char s_left[] = "  %.0f s left";
inline constexpr char another_job_is_running_wait[] = "Another job is running; wait for it, or cancel it.";
inline constexpr char cancelled[] = "Cancelled%s%s";
} // namespace fields

namespace file_browser {
inline constexpr char reload[] = "Reload";
inline constexpr char folders_of_recent_files[] = "Folders of recent files";
inline constexpr char folder[] = "folder";
inline constexpr char name[] = "Name";
inline constexpr char size[] = "Size";
inline constexpr char no_files_of_this_kind[] = "no files of this kind here";
inline constexpr char this_folder_is_empty[] = "this folder is empty";
inline constexpr char a_name_or_a_full[] = "a name or a full path";
inline constexpr char all_files[] = "All files";
inline constexpr char lists_files_of_other_kinds[] = "Lists files of other kinds too.";
inline constexpr char overwrite_question[] = "Overwrite?";
inline constexpr char exists_already[] = "%s exists already.";
inline constexpr char overwrite_button[] = "Overwrite";
inline constexpr char choose_another_name[] = "Choose another name";
} // namespace file_browser

namespace file_dialogs {
inline constexpr char recent_packs[] = "Recent packs";
inline constexpr char none_yet[] = "None yet.";
inline constexpr char compared_with_keys_differ[] = "Compared with %s: %zu keys differ.";
inline constexpr char the_saved_profile[] = "the saved profile";
inline constexpr char key[] = "Key";
inline constexpr char mine[] = "Mine";
inline constexpr char theirs[] = "Theirs";
inline constexpr char take_theirs_room[] = "Take theirs   ";
inline constexpr char take_theirs_button[] = "Take theirs";
inline constexpr char fjell_draws_large_terrains_with[] =
    "Fjell draws large terrains with a bounded screen-space error. This editor tunes its thresholds and budgets, by "
    "eye and by number.";
inline constexpr char a_small_synthetic_landscape_baked[] =
    "A small synthetic landscape. Baked at its first use, which takes some seconds.";
inline constexpr char open_a_file[] = "Open a file...";
inline constexpr char a_pack_fjell_a_profile[] = "A pack (.fjell), a profile, or heights that GDAL reads, to be baked.";
inline constexpr char makes_a_pack_from_heights[] =
    "Makes a pack from a DEM: GeoTIFF, PNG, ASCII grid and whatever else GDAL reads.";
inline constexpr char or_drop_a_file_onto[] = "Or drop a file onto the window.";
inline constexpr char with_the_saved_profile[] = "With the saved profile";
inline constexpr char or_with_another_profile[] = "or with another profile:";
inline constexpr char compare[] = "Compare";
inline constexpr char compare_another[] = "Compare another";
inline constexpr char compares_with_another_profile[] = "Compares with another profile.";
inline constexpr char stop_comparing[] = "Stop comparing";
inline constexpr char the_other_profiles_values_stay[] = "The other profile's values stay visible in the Tune panel.";
inline constexpr char the_profile_has_changes_that[] = "The profile has changes that are not saved: %s.";
inline constexpr char it_has_no_file_yet[] = "it has no file yet";
inline constexpr char the_camera_path_has_changes[] = "The camera path has changes that are not saved: %s.";
inline constexpr char discard[] = "Discard";
inline constexpr char there_is_nothing_to_recover[] = "There is nothing to recover.";
inline constexpr char an_earlier_run_ended_before[] = "An earlier run ended before its changes were saved.";
inline constexpr char of_the_profile[] = "of the profile %s";
inline constexpr char that_had_no_file_yet[] = "that had no file yet";
inline constexpr char a_camera_path_of_points[] = "a camera path of %zu points";
inline constexpr char over[] = "over %s";
inline constexpr char close_this_dialog_to_be[] = "close this dialog to be asked again next time";
} // namespace file_dialogs

namespace graph {
inline constexpr char frames_ago[] = "%zu frames ago";
inline constexpr char click_its_report_drag_zoom[] = "click: its report; drag: zoom";
inline constexpr char g[] = "%.3g G";
inline constexpr char enter_its_highest_frame[] = "Enter: the report of its highest frame.";
} // namespace graph

namespace help {
inline constexpr char w_s_a_d[] = "W S, A D";
inline constexpr char fly_forwards_and_back_left[] = "fly forwards and back, left and right; in orbit: pan";
inline constexpr char e_q[] = "E Q";
inline constexpr char up_and_down[] = "up and down";
inline constexpr char shift[] = "Shift";
inline constexpr char five_times_as_fast[] = "five times as fast";
inline constexpr char arrows_left_drag[] = "Arrows, left drag";
inline constexpr char look_around_in_orbit_turn[] = "look around; in orbit: turn around the centre";
inline constexpr char wheel[] = "Wheel";
inline constexpr char speed_in_orbit_zoom[] = "speed; in orbit: zoom";
inline constexpr char right_drag_shift_drag[] = "Right drag, Shift drag";
inline constexpr char in_orbit_pan[] = "in orbit: pan";
inline constexpr char fly_orbit_follow_the_path[] = "fly, orbit, follow the path";
inline constexpr char look_at_the_whole_terrain[] = "look at the whole terrain";
inline constexpr char click_on_the_overview[] = "Click on the overview";
inline constexpr char fly_there_at_the_same[] = "fly there, at the same height above the ground";
inline constexpr char freeze_refinement_to_look_at[] = "freeze refinement, to look at the mesh from elsewhere";
inline constexpr char record_the_flight_again_stop[] = "record the flight; again: stop";
inline constexpr char add_a_point_where_the[] = "add a point where the camera is";
inline constexpr char left_drag_on_a_point[] = "Left drag on a point";
inline constexpr char move_it_in_the_picture[] =
    "move it, in the picture (Shift: up and down) or on the overview; a click selects it";
inline constexpr char arrows_on_the_timeline[] = "Arrows on the timeline";
inline constexpr char select_a_point_with_shift[] =
    "select a point; with Shift: its time, or up and down the speed after it; Enter: look from there";
inline constexpr char play_again_pause[] = "play; again: pause";
inline constexpr char m_shift_m[] = "M, Shift M";
inline constexpr char next_and_previous_picture_mode[] = "next and previous picture mode";
inline constexpr char wireframe[] = "wireframe";
inline constexpr char l_and_left_drag[] = "L and left drag";
inline constexpr char the_sun_across_its_azimuth[] = "the sun: across its azimuth, up and down its elevation";
inline constexpr char probe_the_ground_under_the[] =
    "probe the ground under the pointer, or where the camera looks; a click or Enter marks a place, another one "
    "measures from there";
inline constexpr char pause_graphs_and_times_again[] = "pause graphs and times; again: go on";
inline constexpr char window[] = "Window";
inline constexpr char hide_the_panels_or_show[] = "hide the panels, or show them";
inline constexpr char the_picture_alone_again_or[] = "the picture alone; again or Esc: all of it";
inline constexpr char keys_move_in_the_panels[] =
    "keys move in the panels: Tab and arrows move, Enter presses, Space changes a value; again: the next panel, after "
    "the last one the camera; Shift F6: the one before; Esc: the camera";
inline constexpr char f10_alt_f[] = "F10, Alt F, Alt E, ...";
inline constexpr char the_menu_again_the_next[] =
    "the first menu, again: the next one; Alt and its first letter: any; arrows move, Enter chooses";
inline constexpr char ctrl_page[] = "Ctrl+Page up, down";
inline constexpr char the_panel_before_and_after[] = "turn to the panel before or after";
inline constexpr char ctrl_tab_and_arrows[] = "Ctrl+Tab and arrows";
inline constexpr char move_a_floating_panel[] = "with F6: move a floating panel; with Shift: resize it";
inline constexpr char page_up_and_down[] = "Page up, down";
inline constexpr char scroll_this_list[] = "scroll this list";
inline constexpr char enter_esc[] = "Enter, Esc";
inline constexpr char in_a_dialog_its_main[] = "in a dialog: its main button, or close it";
inline constexpr char profile_and_program[] = "Profile and program";
inline constexpr char a_smaller_a_larger_threshold[] = "a smaller, a larger threshold";
inline constexpr char ctrl_z_ctrl_shift_z[] = "Ctrl+Z, Ctrl+Shift+Z";
inline constexpr char undo_redo[] = "undo, redo";
inline constexpr char open_a_pack_a_dem[] = "open a pack, a DEM, a profile or a camera path";
inline constexpr char save_the_profile[] = "save the profile";
inline constexpr char ctrl_click_on_a_slider[] = "Ctrl click on a slider";
inline constexpr char type_a_value[] = "type a value";
inline constexpr char this_list_of_keys[] = "this list of keys";
inline constexpr char quit[] = "quit";
inline constexpr char no_messages_yet[] = "No messages yet.";
inline constexpr char times[] = "(%u times)";
} // namespace help

namespace job_dialogs {
inline constexpr char the_frames[] = "the frame's";
inline constexpr char custom_threshold[] = "custom threshold";
inline constexpr char gltf[] = "glTF";
inline constexpr char a_file_that_ends_in[] = "a file that ends in .glb";
inline constexpr char mesh_colours_and_camera_in[] =
    "Mesh, colours and camera in one file, for any viewer or modelling program.";
inline constexpr char the_frames_is_written_as[] =
    "The frame's is written as it is drawn: what the camera sees of it, morphed, as far as its budgets went. With a "
    "custom threshold the whole terrain is refined for this view, whatever the budgets.";
inline constexpr char converged[] = "Converged";
inline constexpr char not_the_frames_mesh_as[] =
    "Not the frame's mesh as it stands, but the one that its view settles on once it has had time and items.";
inline constexpr char pixels[] = "Pixels";
inline constexpr char pixels_about[] = "0.01 to 1000 pixels: a smaller threshold makes a larger file.";
inline constexpr char preview[] = "Preview";
inline constexpr char counts_and_size_of_the[] = "Counts and size of the file, to the byte; nothing is written.";
inline constexpr char export_[] = "Export";
inline constexpr char writes_the_file_an_existing[] =
    "Writes the file; an existing one is replaced only when it is complete.";
inline constexpr char within_px[] = "%s within %.3g px";
inline constexpr char the_terrain[] = "the terrain";
inline constexpr char the_window_with_its_panels[] = "the window, with its panels";
inline constexpr char contents[] = "Contents";
inline constexpr char at_the_current_size_of[] = "At the current size of the window.";
inline constexpr char closes_this_dialog_and_saves[] = "Closes this dialog and saves the next frame.";
inline constexpr char stops_the_job_no_partial[] =
    "Stops the job; no partial file remains. A bake may keep a folder from which it can resume.";
} // namespace job_dialogs

namespace job_panels {
inline constexpr char update_cpu[] = "update (CPU)";
inline constexpr char whole_frame[] = "whole frame";
inline constexpr char budget_us[] = "Budget, us";
inline constexpr char limit_for_the_p99_time[] =
    "Limit for the p99 time of a frame: 10 to 1,000,000 microseconds. A frame at 60 Hz has 16,667.";
inline constexpr char measure[] = "Measure";
inline constexpr char update_cpu_time_of_refinement[] =
    "Update: CPU time of refinement and streaming. Whole frame: with upload and drawing at the picture size of the "
    "profile; slower, and dependent on the graphics driver.";
inline constexpr char frames_0_auto[] = "Frames, 0: auto";
inline constexpr char frames_per_flight_10_to[] =
    "Frames per flight, 10 to 100,000; 0: as many as the path has at 60 Hz, or 840 for an orbit without a path. Fewer "
    "frames fly the same path faster, so more changes per frame.";
inline constexpr char from_to_px[] = "From, to, px";
inline constexpr char the_smallest_threshold_to_try[] = "The smallest threshold to try, in pixels.";
inline constexpr char the_largest_threshold_with_which[] =
    "The largest threshold, with which the search begins, in pixels.";
inline constexpr char use_px[] = "Use %.3g px";
inline constexpr char sets_the_threshold_of_the[] = "Sets the threshold of the profile; one undo step.";
inline constexpr char start[] = "Start";
inline constexpr char flies_the_path_or_an[] =
    "Flies the path, or an orbit, over a terrain of its own until the smallest threshold is found whose p99 keeps the "
    "budget. The view is as large as the profile says.";
inline constexpr char csv[] = "CSV";
inline constexpr char a_file[] = "a file";
inline constexpr char one_line_per_frame_with[] = "One line per frame, with the columns of fjell-fly --csv.";
inline constexpr char frames_about[] =
    "0: as many as the path has at 60 Hz, or 840 for an orbit without a path. Fewer frames fly the same path faster.";
inline constexpr char flies_as_the_profile_says[] =
    "Flies %s as the profile says, over a terrain of its own, in a view of %u x %u.";
inline constexpr char an_orbit[] = "an orbit";
inline constexpr char the_path[] = "the path";
inline constexpr char run[] = "Run";
inline constexpr char starts_at_once_and_flies[] = "Starts at once and flies as fast as possible.";
} // namespace job_panels

namespace levels {
inline constexpr char level_triangles_with_legs_of[] = "level %u: %s triangles with legs of %.4g m";
inline constexpr char triangles_drawn_by_level[] = "Triangles drawn, by level";
inline constexpr char level_0_the_two_base[] = "Level 0: the two base triangles of a tile; each level halves them "
                                               "again. The length is that of a triangle's two equal sides.";
inline constexpr char colour_the_picture_by_level[] = "Colour the picture by level";
inline constexpr char every_triangle_in_its_levels[] =
    "Every triangle in its level's colour, as here. Costs almost nothing.";
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
inline constexpr char keys_move_in_panels[] = "Keys move in panels";
inline constexpr char half_resolution_while_moving[] = "Half resolution while moving";
inline constexpr char probe_the_ground[] = "Probe the ground";
inline constexpr char pause_graphs_and_times[] = "Pause graphs and times";
inline constexpr char the_profile[] = "The profile: %.500s%s";
inline constexpr char the_defaults_not_saved_to[] = "the defaults, not saved to a file yet";
inline constexpr char it_has_changes_that_are[] = "\nIt has changes that are not saved; a click saves them.";
inline constexpr char edit[] = "Edit";
inline constexpr char tools[] = "Tools";
inline constexpr char help[] = "Help";
} // namespace menu

namespace overview {
inline constexpr char overview[] = "Overview";
inline constexpr char click_or_drag_to_fly[] = "Click, or drag, to fly there at the same height above the ground. "
                                               "Yellow: the camera; blue: the frozen camera; pink: the path.";
} // namespace overview

namespace panels {
inline constexpr char tune[] = "Tune";
inline constexpr char pictures[] = "Pictures";
inline constexpr char time[] = "Time";
inline constexpr char budgets[] = "Budgets";
inline constexpr char drag_it_onto_the_picture[] =
    "Drag it onto the picture, or click it twice, and the panel floats there. Ctrl+Page up and down turn to the panels "
    "beside it.";
inline constexpr char click_to_unfold_the_panels[] = "Click to unfold the panels (Tab shows and hides them all).";
inline constexpr char drag_to_resize_the_panels[] =
    "Drag to resize the panels, click to fold them (Tab shows and hides them all).";
inline constexpr char drag_to_divide_the_column[] = "Drag to divide the column.";
inline constexpr char left_below[] = "left, below";
inline constexpr char right_below[] = "right, below";
} // namespace panels

namespace path {
inline constexpr char not_saved_yet[] = "not saved yet";
inline constexpr char none_record_a_flight_add[] = "None. Record a flight, add points one by one, or open a file.";
inline constexpr char as_in_the_file_editing[] = "as in the file; editing converts it to these points";
inline constexpr char play[] = "Play";
inline constexpr char fly_along_the_path_or[] = "Fly along the path, or pause (P).";
inline constexpr char restart[] = "Restart";
inline constexpr char play_from_the_beginning[] = "Play from the beginning.";
inline constexpr char record[] = "Record";
inline constexpr char record_the_flight_as_points[] = "Record the flight as points, which then become the path (R).";
inline constexpr char position_along_the_path_drag[] = "Position along the path; drag to seek.";
inline constexpr char duration[] = "Duration";
inline constexpr char duration_of_the_flight_in[] = "Duration of the flight in seconds, 1 to 3600; times of points are "
                                                    "stretched to it. 0: no times, and a duration chosen "
                                                    "from the terrain's size. Enter applies it.";
inline constexpr char loop[] = "Loop";
inline constexpr char starts_again_at_the_end[] = "Starts again at the end.";
inline constexpr char point[] = "point.%zu";
inline constexpr char select_it_and_look_from[] = "Select it, and look from there.";
inline constexpr char a_point_where_the_camera[] = "A point where the camera is, after the selected one, or last (N).";
inline constexpr char replace[] = "Replace";
inline constexpr char puts_the_selected_point_where[] = "Puts the selected point where the camera is.";
inline constexpr char removes_the_selected_point[] = "Removes the selected point.";
inline constexpr char swaps_the_selected_point_with[] = "Swaps the selected point with the one before.";
inline constexpr char down[] = "Down";
inline constexpr char swaps_the_selected_point_with_the[] = "Swaps the selected point with the one after.";
inline constexpr char turntable[] = "Turntable";
inline constexpr char another_path_once_around_what[] = "Another path: once around what the camera looks at.";
inline constexpr char a_camera_path_from_a[] = "A camera path from a file.";
inline constexpr char save[] = "Save...";
inline constexpr char the_camera_path_to_a[] = "The camera path to a file, as control points in metres.";
inline constexpr char clear[] = "Clear";
inline constexpr char removes_the_path_restore_brings[] = "Removes the path; Restore brings it back.";
inline constexpr char the_path_as_it_was[] = "The path as it was before it was last changed.";
} // namespace path

namespace path_points {
inline constexpr char closed[] = "Closed";
inline constexpr char about_closed[] = "Leads back to the first point, and on from there without a jump in position, "
                                       "direction or speed.";
inline constexpr char insert[] = "Insert";
inline constexpr char about_insert[] = "A point on the path, where it is being played (Insert).";
inline constexpr char constant[] = "Constant";
inline constexpr char about_constant[] = "Times of the points for one speed all along, in the same duration.";
inline constexpr char ease[] = "Ease";
inline constexpr char about_ease[] = "Times of the points from rest to rest, in the same duration.";
inline constexpr char target[] = "Look at";
inline constexpr char all[] = "From all";
inline constexpr char about_all[] = "The camera looks at a target all along: the middle between the probe's marks, its "
                                    "mark, or else the terrain's middle.";
inline constexpr char selected[] = "From selected";
inline constexpr char about_selected[] =
    "The camera looks at that target from the selected point, and from one point to "
    "the next if both have the same.";
inline constexpr char none[] = "Nothing";
inline constexpr char about_none[] = "The selected point has no target any more; if none is selected, all points.";
} // namespace path_points

namespace hands {
inline constexpr char point_drag[] = "Point %zu. Drag: level; with Shift: up and down. Click twice: look from there. "
                                     "Delete: remove it.";
inline constexpr char point_on_map[] =
    "Point %zu. Drag: elsewhere, at the same height above the ground. Click: select it; "
    "twice: look from there.";
inline constexpr char insert_delete[] = "Insert  Delete";
inline constexpr char insert_or_remove_a_point[] = "a point where the path is being played; remove the selected point";
} // namespace hands

namespace picture {
inline constexpr char shaded[] = "Shaded";
inline constexpr char colours_and_light_as_in[] = "Colours and light, as in a game.";
inline constexpr char wire[] = "Wire";
inline constexpr char shaded_with_the_edges_of[] = "Shaded, with the edges of all triangles.";
inline constexpr char every_triangle_in_its_levels[] =
    "Every triangle in its level's colour: coarse ones violet and blue, fine ones orange and red.";
inline constexpr char tiles[] = "Tiles";
inline constexpr char every_tile_in_a_colour[] = "Every tile in a colour different from its neighbours.";
inline constexpr char mips[] = "Mips";
inline constexpr char by_the_mip_that_is[] =
    "By the mip that is drawn: the pack's finest red, the smallest violet. Black: not loaded yet.";
inline constexpr char residency[] = "Residency";
inline constexpr char by_the_finest_geometry_in[] = "By the finest geometry in memory, drawn or not.";
inline constexpr char white_at_the_near_plane[] = "White at the near plane, black beyond the terrain; logarithmic.";
inline constexpr char wireframe[] = "Wireframe";
inline constexpr char edges_of_all_triangles[] = "Edges of all triangles.";
inline constexpr char tile_borders[] = "Tile borders";
inline constexpr char borders_of_tiles_on_the[] = "Borders of tiles, on the ground and in the overview.";
inline constexpr char page_borders[] = "Page borders";
inline constexpr char borders_of_pages_which_are[] = "Borders of pages, which are loaded and evicted as a whole.";
inline constexpr char bounding_spheres[] = "Bounding spheres";
inline constexpr char around_vertices_as_refinement_uses[] = "Around vertices, as refinement uses them.";
inline constexpr char culled[] = "Culled";
inline constexpr char with_refinement_frozen_culled_tiles[] =
    "With refinement frozen: culled tiles, and the frustum of the frozen camera.";
inline constexpr char true_error[] = "True error";
inline constexpr char distance_of_the_mesh_from[] =
    "Distance of the mesh from the full-resolution terrain, in pixels; hatched where it breaks the bound. Replaces the "
    "picture; all heights are read first.";
inline constexpr char the_path_its_points_and[] =
    "The path, its points and the recording in progress; hidden during playback.";
inline constexpr char contours[] = "Contours";
inline constexpr char lines_of_equal_height_every[] = "Lines of equal height, every fifth one wider.";
inline constexpr char steep_ground_in_bands_from[] = "Steep ground in bands, from 15, 25, 35 and 45 degrees on.";
inline constexpr char this_pack_has_no_maps[] = "This pack has no maps.";
inline constexpr char px_the_bound[] = "%.3g px: the bound";
inline constexpr char hatched_above_the_bound[] = "hatched: above the bound";
inline constexpr char no_reference[] = "no reference";
inline constexpr char contours_every_m_wider_every[] = "Contours every %.4g m, wider every %.4g m.";
inline constexpr char slope_degrees[] = "Slope, degrees:";
inline constexpr char from[] = "from %d";
inline constexpr char and_steeper[] = "%d and steeper";
inline constexpr char culled_tiles_are_out_of[] =
    "Culled tiles are out of view: freeze refinement (F), and look from elsewhere.";
inline constexpr char the_reference_heights_could_not[] =
    "The reference heights could not be read; see Help > Messages.";
inline constexpr char reading_heights[] = "Reading heights: %.0f%%";
inline constexpr char true_error_key[] = "True error:";
inline constexpr char interface[] = "Interface";
inline constexpr char size_of_text_and_controls[] = "Size of text and controls.";
inline constexpr char picture_mode_m_next[] = "Picture mode (M: next)";
inline constexpr char overlays[] = "Overlays";
} // namespace picture

namespace pictures {
inline constexpr char go[] = "go.%zu";
inline constexpr char look_from_there[] = "Look from there.";
inline constexpr char remove[] = "remove.%zu";
inline constexpr char removes_this_bookmark[] = "Removes this bookmark.";
inline constexpr char bookmarks[] = "Bookmarks";
inline constexpr char a_name_or_none[] = "a name, or none";
inline constexpr char what_the_bookmark_is_called[] = "What the bookmark is called; without a name it is numbered.";
inline constexpr char keeps_where_the_camera_is[] = "Keeps where the camera is, with a thumbnail.";
inline constexpr char none_of_this_terrain_yet[] = "None of this terrain yet.";
inline constexpr char this_view[] = "this view";
inline constexpr char the_path_frame_by_frame[] = "the path, frame by frame";
inline constexpr char render[] = "Render";
inline constexpr char frames[] = "-frames";
inline constexpr char what[] = "What";
inline constexpr char a_picture_of_what_the[] =
    "A picture of what the camera sees, of any size; or one for each frame of the camera path.";
inline constexpr char folder[] = "Folder";
inline constexpr char a_folder[] = "a folder";
inline constexpr char the_pictures_go_there_frame[] = "The pictures go there: frame_00000.png and so on.";
inline constexpr char width_px[] = "Width, px";
inline constexpr char of_the_picture_whatever_the[] = "Of the picture, whatever the window has.";
inline constexpr char height_px[] = "Height, px";
inline constexpr char pictures_a_second[] = "Pictures a second";
inline constexpr char of_the_paths_flight_1[] = "Of the path's flight: 1 to 240.";
inline constexpr char pictures_of_s[] = "%s pictures of %.1f s";
inline constexpr char draws_beside_the_frame_with[] =
    "Draws beside the frame, with the threshold held in every picture whatever a frame's budgets are. Above the width "
    "of the profile's view more detail is refined, as for a larger screen.";
} // namespace pictures

namespace probe {
inline constexpr char place[] = "Place";
inline constexpr char m_away[] = "%.20s m away";
inline constexpr char tile_page[] = "%d, %d: tile %u, %u, page %u";
inline constexpr char sample[] = "Sample";
inline constexpr char full_resolution[] = "full resolution";
inline constexpr char within_m_pages_missing[] = "within %.3g m: pages missing";
inline constexpr char ground[] = "Ground";
inline constexpr char nothing_is_drawn_here[] = "nothing is drawn here";
inline constexpr char level_off_by_m_px[] = "level %d, off by %.2f m: %.2f px";
inline constexpr char down[] = "down";
inline constexpr char up[] = "up";
inline constexpr char one_to_two[] = "1 to 2";
inline constexpr char to_m[] = "%.20s to %.20s m";
inline constexpr char no_ground_here[] = "no ground here";
inline constexpr char move_the_pointer_over_the[] = "move the pointer over the ground";
inline constexpr char click_the_second_place_esc[] = "Click: the second place. Esc or I: end.";
inline constexpr char click_mark_a_place_then[] = "Click: mark a place, then another. Esc or I: end.";
} // namespace probe

namespace runs {
inline constexpr char of_the_path[] = "%.0f%% of the path";
inline constexpr char unbounded[] = "%.24s: unbounded";
inline constexpr char click_look_from_there[] = "click: look from there";
inline constexpr char at_px_frames_vertices_of[] =
    "%s at %.3g px: %s frames, %s vertices, %.1f%% of them converged; p99 of the error %.3g px";
inline constexpr char update_ms[] = "update, ms";
inline constexpr char forget[] = "forget.%zu";
inline constexpr char drops_this_run_from_the[] = "Drops this run from the panel; its CSV stays.";
inline constexpr char budget_spent[] = "  budget spent";
inline constexpr char share_of_the_path_the[] =
    "Share of the path, the update's time, and the largest error there. Click: look from there.";
inline constexpr char dearest_places[] = "Dearest places";
inline constexpr char places_beyond_the_threshold[] = "Places beyond the threshold";
inline constexpr char nothing[] = "nothing";
inline constexpr char time[] = "time";
inline constexpr char error[] = "error";
inline constexpr char path_on_the_overview_coloured[] = "Path on the overview coloured by";
inline constexpr char colours_the_overview_in_the[] =
    "Colours the overview in the Camera panel along the latest run's path: blue is cheap or exact, red the run's p99 "
    "time or its threshold, white beyond that.";
inline constexpr char runs[] = "Runs";
inline constexpr char red_below_a_budget_is[] = "red below: a budget is spent";
} // namespace runs

namespace status {
inline constexpr char the_threshold_that_the_mesh[] =
    "The threshold that the mesh keeps now, and why it is not the requested one.";
inline constexpr char vertices_exhausted[] = "vertices exhausted";
inline constexpr char triangles_exhausted[] = "triangles exhausted";
inline constexpr char indices_exhausted[] = "indices exhausted";
inline constexpr char page_slots_exhausted[] = "page slots exhausted";
inline constexpr char pages_missing[] = "pages missing";
inline constexpr char lags_items_exhausted[] = "lags: items exhausted";
inline constexpr char lags_time_exhausted[] = "lags: time exhausted";
inline constexpr char morphing[] = "morphing";
inline constexpr char error_unbounded[] = "error unbounded, %s";
inline constexpr char within_px[] = "within %.4g px%s%s";
inline constexpr char whether_everything_that_the_view[] = "Whether everything that the view needs is loaded.";
inline constexpr char streaming_complete[] = "streaming: complete";
inline constexpr char streaming_wanted_in_flight[] = "streaming: %.12s wanted, %.12s in flight";
inline constexpr char no_terrain_is_open[] = "no terrain is open";
inline constexpr char use_file_open_or_drop[] = "Use File > Open, or drop a file here.";
inline constexpr char update_about[] = "99% of the last 512 updates took at most this long.";
inline constexpr char update_p99_ms[] = "update p99 %s ms";
inline constexpr char frames_per_second_from_the[] = "Frames per second, from the median frame time.";
inline constexpr char triangles_drawn_in_this_frame[] = "Triangles drawn in this frame.";
inline constexpr char triangles[] = "%s triangles";
} // namespace status

namespace streaming {
inline constexpr char the_whole_terrain_is_in[] =
    "The whole terrain is in memory: all of its %s pages were read when it was opened.";
inline constexpr char to_stream_it_give_the[] =
    "To stream it, give the profile fewer page slots than the pack has pages (stream.page_slots in the Tune panel), at "
    "least one per tile. Pages are then read when the view wants them.";
inline constexpr char stream_with_page_slots[] = "Stream with %s page slots";
inline constexpr char half_of_its_pages_the[] =
    "Half of its pages. The pack is reopened and the view stays; Undo reverts it.";
inline constexpr char geometry[] = "Geometry";
inline constexpr char pages_for_this_view[] = "Pages for this view";
inline constexpr char complete[] = "complete";
inline constexpr char incomplete[] = "incomplete";
inline constexpr char complete_the_threshold_holds_against[] =
    "Complete: the threshold holds against the whole terrain.";
inline constexpr char wanted_missing[] = "Wanted, missing";
inline constexpr char pages_that_the_views_want[] =
    "Pages that the views want and that are not loaded although the coarser ones above them are.";
inline constexpr char accepted_left[] = "Accepted, left";
inline constexpr char arrived_pages_that_were_accepted[] =
    "Arrived pages that were accepted in this frame, and those left for the next ones (stream.pages).";
inline constexpr char evicting[] = "Evicting";
inline constexpr char pages_that_are_no_longer[] =
    "Pages that are no longer wanted, evicted as soon as the mesh does not use them.";
inline constexpr char of[] = "%s of %s";
inline constexpr char missing_error[] = "Missing error";
inline constexpr char the_largest_error_on_screen[] =
    "The largest error on screen that a missing page may hide, in pixels.";
inline constexpr char maps[] = "Maps";
inline constexpr char mips_for_this_view[] = "Mips for this view";
inline constexpr char complete_loaded_and_faded_in[] = "Complete: loaded and faded in.";
inline constexpr char missing_mips[] = "Missing mips";
inline constexpr char mips_that_the_blurriest_tile[] = "Mips that the blurriest tile in view lacks.";
inline constexpr char on_the_gpu[] = "On the GPU";
inline constexpr char reading[] = "Reading";
inline constexpr char in_flight[] = "In flight";
inline constexpr char pages_and_mips_that_were[] =
    "Pages and mips that were requested and have not arrived (stream.page_requests, stream.map_requests).";
inline constexpr char pages_mips[] = "Pages, mips";
inline constexpr char bytes[] = "Bytes";
inline constexpr char compressed_in_total[] = "Compressed, in total.";
inline constexpr char reads[] = "Reads";
inline constexpr char read_rate[] = "Read rate";
inline constexpr char over_the_time_that_the[] = "Over the time that the reader's thread spent reading.";
inline constexpr char decompression[] = "Decompression";
inline constexpr char checking_and_decompressing_on_the[] =
    "Checking and decompressing on the reader's thread, in total.";
inline constexpr char withdrawn[] = "Withdrawn";
inline constexpr char requests_that_were_no_longer[] = "Requests that were no longer wanted when their turn came.";
inline constexpr char failed[] = "Failed";
inline constexpr char pages_and_mips_that_are[] =
    "Pages and mips that are unreadable or damaged; the terrain is coarser there. See Help > Messages.";
inline constexpr char coarse_terrain_loaded[] = "coarse terrain loaded";
inline constexpr char loading_coarse_terrain[] = "loading coarse terrain";
inline constexpr char whether_the_coarsest_page_and[] =
    "Whether the coarsest page and the smallest mips of every tile are loaded.";
inline constexpr char pages_mips_unit[] = "pages, mips";
inline constexpr char wanted[] = "wanted";
inline constexpr char in_flight_line[] = "in flight";
} // namespace streaming

namespace time {
inline constexpr char frame_at_60_hz[] = "16.7 ms: 60 Hz";
inline constexpr char what_has_changed_of_the[] = "What has changed of the mesh, to the driver.";
inline constexpr char the_terrain_what_giving_it[] = "The terrain: what giving it to the driver took.";
inline constexpr char the_picture_copied_panels_drawn[] =
    "The picture copied, panels drawn, the swap. The GPU, or the software renderer, catches up here with what it was "
    "given; with vertical sync it waits here.";
inline constexpr char input_the_overview_and_what[] = "Input, the overview, and what is rebuilt.";
inline constexpr char last[] = "last";
inline constexpr char frame[] = "Frame";
inline constexpr char all_that_the_editor_does[] =
    "All that the editor does for a frame whose terrain has changed. Waiting for input does not count.";
inline constexpr char update[] = "Update";
inline constexpr char the_methods_update_on_the[] = "The method's update on the CPU.";
inline constexpr char prepare[] = "  prepare";
inline constexpr char part_of_the_update_views[] =
    "Part of the update: views, arrived pages, and which groups have work.";
inline constexpr char refine[] = "  refine";
inline constexpr char part_of_the_update_evaluating[] =
    "Part of the update: evaluating, activating and deactivating vertices.";
inline constexpr char output[] = "  output";
inline constexpr char part_of_the_update_writing[] = "Part of the update: writing triangles and draw ranges.";
inline constexpr char accepting_arrived_pages_and_mips[] = "Accepting arrived pages and mips, and requesting others.";
inline constexpr char upload[] = "Upload";
inline constexpr char draw[] = "Draw";
inline constexpr char present[] = "Present";
inline constexpr char editor[] = "Editor";
inline constexpr char the_editors_own_code_panels[] =
    "The editor's own code: panels, commands and measures. Should stay below 1 ms.";
inline constexpr char other[] = "Other";
inline constexpr char gpu[] = "GPU";
inline constexpr char what_the_gpu_took_by[] =
    "What the GPU took, by its own clock, of some frames before: beside the CPU, so none of the parts above.";
inline constexpr char gpu_not_measured_software_draws[] = "GPU: not measured; software draws, in Present.";
inline constexpr char update_part[] = "update";
inline constexpr char the_methods_update_on_the_cpu[] = "The method's update on the CPU, and streaming.";
inline constexpr char upload_part[] = "upload";
inline constexpr char draw_part[] = "draw";
inline constexpr char present_part[] = "present";
inline constexpr char editor_part[] = "editor";
inline constexpr char the_editors_own_code[] = "The editor's own code.";
inline constexpr char other_part[] = "other";
inline constexpr char frame_mean_of[] = "Frame, mean of %zu";
inline constexpr char this_frame[] = "This frame";
inline constexpr char before_the_newest[] = "Before the newest";
inline constexpr char frames[] = "%s frames";
inline constexpr char threshold[] = "Threshold";
inline constexpr char px_of[] = "%.3g px of %.3g";
inline constexpr char activated_deactivated[] = "Activated, deactivated";
inline constexpr char triangles_drawn[] = "Triangles drawn";
inline constexpr char uploaded[] = "Uploaded";
inline constexpr char go_to_its_camera[] = "Go to its camera";
inline constexpr char places_the_camera_where_this[] = "Places the camera where this frame was drawn from.";
inline constexpr char all_frames[] = "All frames";
inline constexpr char shows_the_mean_of_all[] = "Shows the mean of all measured frames again.";
inline constexpr char continue_[] = "Continue###hold";
inline constexpr char pause[] = "Pause###hold";
inline constexpr char measures_on_over_all_frames[] = "Measures on, over all frames again (T).";
inline constexpr char graphs_and_times_stand_still[] = "Graphs and times stand still, to be looked at (T).";
inline constexpr char zoom_out[] = "Zoom out";
inline constexpr char zoom_in[] = "Zoom in";
inline constexpr char half_as_many_frames_around[] =
    "Pauses, and shows half as many frames, around the chosen one. Or drag over a graph.";
inline constexpr char the_frame_before[] = "The report of the frame before it.";
inline constexpr char the_frame_after[] = "The report of the frame after it.";
inline constexpr char shows_all_frames_again_drag[] = "Shows all frames again. Drag over a graph to zoom in.";
inline constexpr char paused[] = "paused";
inline constexpr char no_frame_has_been_measured[] = "No frame has been measured yet: fly. A still view costs nothing.";
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
inline constexpr char point_at[] = "point %zu: %.2f s";
inline constexpr char stretch_at[] = "from point %zu: %s on average";
inline constexpr char speed_mark[] = "speed.%zu";
inline constexpr char playhead_drag[] =
    "%.1f s: %s. Click or drag: go there; clicked twice on the lower edge: a new point there.";
inline constexpr char first_point_drag[] = "Point %zu, where times begin. Click: select it; twice: look from there.";
inline constexpr char point_drag[] = "Point %zu at %.2f s. Drag: another time, between its neighbours; with Shift not "
                                     "drawn to the lines and the playhead. Click: select it; twice: look from there. "
                                     "Keys: left and right select a point, with Shift they move it, with Ctrl by a "
                                     "whole second; Enter: look from there; Delete: remove it.";
inline constexpr char speed_drag[] =
    "%s; %s on average from point %zu to %zu. Drag up or down: faster or slower there; the "
    "times of the points after it follow. Keys: Shift with up and down.";
} // namespace timeline

namespace tune {
inline constexpr char a_change_takes_effect_in[] = "A change takes effect in the next frame.";
inline constexpr char a_change_reallocates_the_methods[] = "A change reallocates the method's memory.";
inline constexpr char a_change_reopens_the_pack[] = "A change reopens the pack; the view stays.";
inline constexpr char range_to[] = "Range: %.10g to %.10g%s%s\n";
inline constexpr char not_used_now[] = "\n\nNot used now: ";
inline constexpr char reset[] = "reset";
inline constexpr char reset_to_the_saved_value[] = "Reset to the saved value: %s";
inline constexpr char on[] = "on";
inline constexpr char compared[] = "compared: %s";
} // namespace tune

namespace tune_cost {
inline constexpr char gpu[] = " GPU";
inline constexpr char used[] = ", used ";
inline constexpr char peak[] = ", peak ";
inline constexpr char gpu_used[] = " GPU, used ";
inline constexpr char last_frame[] = "last frame ";
inline constexpr char last_update_us[] = "last update %s us";
inline constexpr char keeps_px[] = "keeps %.*f px";
inline constexpr char triangles_drawn[] = " triangles drawn";
inline constexpr char the_pack_has[] = ", the pack has ";
inline constexpr char in_flight_with_mips[] = ", in flight %u with mips";
inline constexpr char up_to[] = "up to ";
inline constexpr char last_frame_left[] = "last frame %u, left %u";
inline constexpr char for_the_incremental_method_only[] = "for the incremental method only.";
inline constexpr char for_the_recursive_method_only[] = "for the recursive method only.";
inline constexpr char for_streaming_only_a_pack[] =
    "for streaming only. A pack is streamed when it has more pages than page slots.";
inline constexpr char for_morph_time_only[] = "for morph \"time\" only.";
} // namespace tune_cost

namespace tune_curve {
inline constexpr char p50_us_p99_us_max[] = "p50 %s us, p99 %s us, max %s us";
inline constexpr char vertices_flights_of_frames[] = "%s vertices; %u flights of %u frames";
inline constexpr char of_the_frames_reached_it[] = "%.1f%% of the frames reached it";
inline constexpr char dearest_frames[] = "dearest frames: %.0f%% %s";
inline constexpr char keeps_the_budget[] = "keeps the budget";
inline constexpr char does_not_keep_the_budget[] = "does not keep the budget";
inline constexpr char the_curve_appears_here_flight[] = "The curve appears here, flight by flight.";
inline constexpr char p99_us[] = "p99, us";
inline constexpr char p50_us[] = "p50, us";
inline constexpr char threshold_px_finer_to_the[] = "threshold, px (finer to the right)";
} // namespace tune_curve

namespace view {
inline constexpr char refinement_frozen_f_to_release[] = "Refinement frozen (F to release)";
inline constexpr char recording_points_r_to_stop[] = "Recording: %zu points (R to stop)";
inline constexpr char path_of_s_p_to[] = "Path: %.1f of %.1f s (P to pause)";
inline constexpr char orbit_1_to_fly[] = "Orbit (1 to fly)";
inline constexpr char opening[] = "Opening %.500s";
inline constexpr char no_terrain_is_open_use[] = "No terrain is open: use File > Open, or drop a file here";
} // namespace view

} // namespace fjell::editor::strings
