// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "problems/problem.hpp"

/// The table of answers to commands: what was done, and why not.
namespace slam::answer {

// Of all commands. Texts: a name, words.
inline constexpr ProblemKind kTooMany{"too_many_commands", "too many commands at once"};
inline constexpr ProblemKind kUnknownVerb{"unknown_verb", "unknown verb; known are {0}"};
inline constexpr ProblemKind kNoMode{"no_mode", "a mode is slam or localise"};
inline constexpr ProblemKind kPoseSet{"pose_set", "pose set"};
inline constexpr ProblemKind kPoseAbsurd{"pose_absurd",
                                         "{0}; the pose stays as it was; give x and y in metres from the map's origin, "
                                         "theta in radians"};

// Maps. Texts: name of the map, another name. Numbers: turn [deg], x and y [m].
inline constexpr ProblemKind kSaved{"saved", "saved as {0}"};
inline constexpr ProblemKind kFilesSaved{"files_saved", "saved to {0}.yaml"};
inline constexpr ProblemKind kFilesNotSaved{"files_not_saved", "not saved; the log says why"};
inline constexpr ProblemKind kFilesNowhere{"files_nowhere", "output.map is not set in the configuration"};
inline constexpr ProblemKind kFilesHavePlace{"files_have_place", "the place is output.map; give no argument"};
inline constexpr ProblemKind kFilesUnderWay{"files_under_way", "a map is being saved already"};
inline constexpr ProblemKind kLoaded{"loaded", "loaded {0}; looking for the robot in it"};
inline constexpr ProblemKind kFloorLoaded{"floor_loaded", "the robot was found in map {0}, which is loaded"};
inline constexpr ProblemKind kNewMap{"new_map", "a new map begins"};
inline constexpr ProblemKind kLocalises{
    "localises", "localises in {0}, which stays as it is; the next start takes mode from the configuration"};
inline constexpr ProblemKind kExtends{"extends", "extends {0}; the next start takes mode from the configuration"};
inline constexpr ProblemKind kStraightened{"straightened",
                                           "the map is turned by {#0.2} deg; its origin was at x {#1.3} m, y {#2.3} m"};
inline constexpr ProblemKind kRenamed{"renamed", "map {0} is now {1}"};
inline constexpr ProblemKind kDeleted{"deleted", "map {0} is deleted; until the next one is, it can be restored"};
inline constexpr ProblemKind kRestored{"restored", "map {0} is back"};
// What follows a colon is a problem of the disk.
inline constexpr ProblemKind kNotStored{"not_stored", "not stored:"};
inline constexpr ProblemKind kMapNotStored{"map_not_stored", "the map is not stored:"};
inline constexpr ProblemKind kOldMapNotStored{"old_map_not_stored", "the one before is not stored:"};
inline constexpr ProblemKind kStraightNotStored{"straight_not_stored",
                                                "the map stays as it is: the straightened one is not stored:"};
inline constexpr ProblemKind kDiskSilent{"disk_silent", "the disk does not answer; try again when it does"};
inline constexpr ProblemKind kMapBusy{"map_busy", "another command about the map is being carried out"};
inline constexpr ProblemKind kNoStore{"no_store", "store.directory is not set in the configuration"};
inline constexpr ProblemKind kNoMapName{"no_map_name", "\"{0}\" is no name of a map; use letters, digits, - and _"};
inline constexpr ProblemKind kNoSuchMap{"no_such_map", "there is no map \"{0}\"; slamctl maps lists them"};
inline constexpr ProblemKind kPlanName{"plan_name", "\"{0}\" would be taken for a floor plan's file"};
inline constexpr ProblemKind kMapExists{"map_exists", "there is a map \"{0}\" already"};
inline constexpr ProblemKind kNoneDeleted{"none_deleted", "no deleted map is kept; only the one deleted last is"};
inline constexpr ProblemKind kMapOpen{"map_open", "slamd has map {0} open; load another one first"};
inline constexpr ProblemKind kMapBegins{"map_begins",
                                        "store.map names map {0}, with which slamd begins; set another one first"};
inline constexpr ProblemKind kMapOfOthers{"map_of_others", "another program has map {0} open"};
inline constexpr ProblemKind kModeAlready{"mode_already", "mode is \"{0}\" already"};
inline constexpr ProblemKind kPictureStays{"picture_stays", "a picture of a map cannot be extended"};
inline constexpr ProblemKind kNoMapToLocalise{"no_map_to_localise", "there is no stored map to localise in"};
inline constexpr ProblemKind kMapStays{
    "map_stays", "mode is \"localise\": the map stays as it is; slamctl mode slam, edit it, and slamctl mode localise"};
inline constexpr ProblemKind kNoReset{"no_reset",
                                      "mode is \"localise\": the map stays; use set-pose to say where the robot is"};
inline constexpr ProblemKind kMapSame{"map_same", "mode is \"localise\": the map does not change"};
inline constexpr ProblemKind kNotLocalised{
    "not_localised", "the robot is not localised: it would be lost in the turned map; try again when it is"};
inline constexpr ProblemKind kFewWalls{"few_walls", "the map has too few walls to be straightened by; drive on"};
// Numbers: cells that agree, and what is needed [%]; outline of what was moved, and of other pieces [m].
inline constexpr ProblemKind kOtherFurniture{
    "other_furniture",
    "{0} and {1} have the same walls, but {#0.1} % of the obstacles where both have been are the same, and {#1} % are "
    "needed; of the others' outlines {#2.1} m look like pieces that were moved, {#3.1} m do not: another floor that "
    "looks alike, "
    "or a home whose furniture was moved far or replaced",
    "nothing is stored", "if the furniture was moved, give --moved; of two floors keep both maps"};
inline constexpr ProblemKind kNoPlace{"no_place", "there is no place \"{0}\"; slamctl map place makes one"};

// Edits. Numbers: the edit; or as the words have them. Text: a map.
inline constexpr ProblemKind kEditMade{"edit_made", "edit {#0} is made"};
inline constexpr ProblemKind kEditUndone{"edit_undone", "edit {#0} is undone (its last step)"};
inline constexpr ProblemKind kEditRedone{"edit_redone", "edit {#0} is done again (its last step)"};
inline constexpr ProblemKind kEditRemoved{"edit_removed", "edit {#0} is removed"};
inline constexpr ProblemKind kStoredIn{"stored_in", "stored in {0}"};
inline constexpr ProblemKind kNotStoredYet{"not_stored_yet", "not stored yet: the disk does not answer"};
inline constexpr ProblemKind kLostAtEnd{"lost_at_end", "lost at the end: store.directory is not set"};
inline constexpr ProblemKind kNoEdit{"no_edit", "there is no edit {#0}; slamctl map edits lists them"};
inline constexpr ProblemKind kNoEditNumber{"no_edit_number", "\"{0}\" is no number of an edit"};
inline constexpr ProblemKind kNothingToUndo{"nothing_to_undo", "nothing is left to undo"};
inline constexpr ProblemKind kNothingUndone{"nothing_undone", "nothing was undone"};
inline constexpr ProblemKind kMostEdits{"most_edits", "the map has {#0} edits, which is the most; remove some"};
inline constexpr ProblemKind kNoMapYet{"no_map_yet", "there is no map yet to edit"};
inline constexpr ProblemKind kPointFar{
    "point_far", "a point lies more than {#0} m from all that the map knows; give x and y in metres"};
inline constexpr ProblemKind kRobotLost{"robot_lost",
                                        "the robot would get lost: of what it sees around it the map would keep {#0} "
                                        "%; drive it away, erase less, or force it"};
inline constexpr ProblemKind kNameMissing{"name_missing", "a room or place needs a name"};
inline constexpr ProblemKind kNameLong{"name_long", "the name has {#0} bytes; at most {#1} are allowed"};
inline constexpr ProblemKind kNameControls{"name_controls", "the name holds a control character"};
inline constexpr ProblemKind kAuthorBad{"author_bad", "author: {0}"};
inline constexpr ProblemKind kManyCorners{"many_corners", "{#0} corners; at most {#1} are allowed"};
inline constexpr ProblemKind kPointAbsurd{"point_absurd", "{0}"};
inline constexpr ProblemKind kPlaceNoPoint{"place_no_point", "a place has one point and a heading"};
inline constexpr ProblemKind kPlaceHeading{"place_heading", "the heading is no angle in radians"};
inline constexpr ProblemKind kPlaceSigma{"place_sigma", "the sigma of a place is no length"};
inline constexpr ProblemKind kWallShort{"wall_short", "a wall needs two points"};
inline constexpr ProblemKind kWallSame{"wall_same", "two points of the wall are the same"};
inline constexpr ProblemKind kFewCorners{"few_corners", "an outline needs three corners, {#0} are given"};
inline constexpr ProblemKind kOutlineCrosses{
    "outline_crosses", "the outline crosses or touches itself; give its corners one after the other"};

// Logs. Text: a file or folder.
inline constexpr ProblemKind kLogNotSet{"log_not_set", "log.directory is not set in the configuration"};
inline constexpr ProblemKind kLogging{"logging", "logging into {0}"};
inline constexpr ProblemKind kLoggingAlready{"logging_already", "it is being logged already, into {0}"};
inline constexpr ProblemKind kLogStopped{"log_stopped", "logging stopped"};
inline constexpr ProblemKind kLogWasStopped{"log_was_stopped", "nothing was being logged"};
inline constexpr ProblemKind kMarked{"marked", "marked {0}"};
inline constexpr ProblemKind kNotMarked{"not_marked", "not marked:"};
inline constexpr ProblemKind kMarkStopped{
    "mark_stopped", "nothing is being logged: the log is stopped; begin it with slamctl log start, and mark again"};
inline constexpr ProblemKind kMarkEmpty{"mark_empty",
                                        "nothing has come yet that could be logged; mark again in a second"};
inline constexpr ProblemKind kMarkNoWords{"mark_no_words", "say what has happened: log_mark needs an argument"};

// slam-web's own. Number: [s].
inline constexpr ProblemKind kWebBusy{"web_busy", "another command is being carried out; try again when it is done"};
inline constexpr ProblemKind kWebSilent{"web_silent",
                                        "slamd gave no answer; is it running, with lcm.commands = true or its socket?"};
inline constexpr ProblemKind kWebOff{"web_off", "commands are off; set web.commands = true, and restart slam-web"};
inline constexpr ProblemKind kNeedsToken{"needs_token", "this needs the token"};
inline constexpr ProblemKind kWrongToken{"wrong_token", "the token is not web.token of the robot's configuration"};
inline constexpr ProblemKind kManyTokens{"many_tokens",
                                         "too many wrong tokens came from this address; try again in {#0} s"};
inline constexpr ProblemKind kPressOver{"press_over", "this press has ended; let go, and press again"};
inline constexpr ProblemKind kOtherDrives{"other_drives", "another page drives the robot"};
inline constexpr ProblemKind kWebEnds{"web_ends", "slam-web ends"};
inline constexpr ProblemKind kStopNotSent{"stop_not_sent",
                                          "the stop cannot be sent over LCM; slamd stops by itself in half a second"};
inline constexpr ProblemKind kSpeedNotSent{"speed_not_sent",
                                           "the speed cannot be sent over LCM; slamctl doctor looks for the cause"};
inline constexpr ProblemKind kSpeedsOff{"speeds_off", "speeds are off; set base.speed_commands = true, and restart"};

// The set-up's page.
inline constexpr ProblemKind kSetupAnswered{"setup_answered",
                                            "this question is answered already; the page shows the present one"};
inline constexpr ProblemKind kSetupStands{
    "setup_stands", "the robot is not driven now: only while its drive is recorded, and if you chose the joystick"};

}  // namespace slam::answer
