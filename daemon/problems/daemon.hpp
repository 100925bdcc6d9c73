// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "problems/problem.hpp"

/// The table of problems: what can be wrong with slamd's surroundings.
namespace slam::problem {

// Disks. Texts: folder, nothing, what the system says.
inline constexpr ProblemKind kDiskFull{"disk_full", "no space on {0}{2}", "",
                                       "make room: sudo du -sh {0}/*; slamctl log list"};
inline constexpr ProblemKind kDiskQuota{"disk_quota", "the disk quota of {0} is used up{2}", "",
                                        "make room: sudo du -sh {0}/*"};
inline constexpr ProblemKind kDiskReadOnly{"disk_read_only", "{0} is read-only", "",
                                           "sudo dmesg | tail says whether the kernel has found errors on the disk; "
                                           "replace it, or sudo mount -o remount,rw its "
                                           "mount point"};
inline constexpr ProblemKind kDiskErrors{"disk_errors", "the disk of {0} reports errors: {2}", "",
                                         "sudo dmesg | tail says which; check its plug, replace it"};
inline constexpr ProblemKind kDiskRefuses{"disk_refuses", "{2}", "",
                                          "make the folder writable for slamd: sudo chown -R slamd: {0}"};
inline constexpr ProblemKind kDiskInTheWay{"disk_in_the_way", "{2}", "",
                                           "something else lies in its place: move it out of {0}"};
inline constexpr ProblemKind kDiskGone{"disk_gone", "{2}: has its disk gone?", "",
                                       "plug the disk in and mount it again, or make the folder {0}"};
inline constexpr ProblemKind kDiskFails{"disk_fails", "{2}", "", "make room, or its folder writable"};
inline constexpr ProblemKind kDiskHangs{"disk_hangs", "the disk does not answer",
                                        "slamd goes on and writes what is new when it does",
                                        "is it broken, or too slow? ({#0} s so far)"};

// What is kept on a disk. Texts: what it is, nothing, why. Numbers: messages; or [MB] free and kept free.
inline constexpr ProblemKind kMapImplausible{"map_implausible", "the map {2}", "",
                                             "slamctl reset begins a new map; what is stored stays"};
inline constexpr ProblemKind kMapUnreadable{"map_unreadable", "{2}", "",
                                            "begin a new one: slamctl reset; what was stored before stays"};
inline constexpr ProblemKind kMapToLocaliseMissing{"map_to_localise_missing", "no map to localise in: {2}",
                                                   "slamd has no pose until there is one, and looks again",
                                                   "put it there, or change store.map"};
inline constexpr ProblemKind kMapNotTaken{"map_not_taken", "{2}",
                                          "slamd draws a new map that is not stored, and tries again",
                                          "fix that one, or change store.map"};
inline constexpr ProblemKind kMapFilesNotSaved{"map_files_not_saved", "{2}",
                                               "the map files cannot be saved, slamd goes on",
                                               "make their folder writable and room in it, or change output.map"};
inline constexpr ProblemKind kRecordNotWritten{"record_not_written", "{2}",
                                               "the record is not written, slamd goes on without and tries again",
                                               "make room or the folder for it, or change output.record"};
inline constexpr const char *kNothingLogged = "nothing is logged, slamd goes on without and tries again",
                            *kLogFix = "make room (slamctl log list), or change log.directory";
inline constexpr ProblemKind kLogNotWritten{"log_not_written", "{2}", kNothingLogged, kLogFix};
inline constexpr ProblemKind kLogNoRoom{
    "log_no_room", "{0}: only {#0} MB are free where log.floor keeps {#1} MB for the maps", kNothingLogged, kLogFix};
inline constexpr ProblemKind kMessagesLost{"messages_lost",
                                           "{#0} messages are missing in it: the disk was away or too slow"};
inline constexpr ProblemKind kMessagesStarved{"messages_starved",
                                              "{#0} messages are missing in it: the computer was overloaded"};

// The pose. Numbers: points, points needed; failures; drift [deg/min]; ways' difference [m].
inline constexpr const char *kDriveOn = "drive slowly on where it has been, or give its place: slamctl set-pose",
                            *kOtherSensors = "the pose goes on by the other sensors";
inline constexpr ProblemKind kNoScans{"no_scans", "waits for the lidar"};
inline constexpr ProblemKind kNoSource{
    "no_source", "wheels, gyro and lidar are all silent, so that nothing shows how the robot moves",
    "no pose is published until one of them is back",
    "check what they share: power, USB hub, the program that sends them"};
inline constexpr ProblemKind kNoScanYet{"no_scan_yet", "waits for the first scan"};
inline constexpr ProblemKind kFewPoints{
    "few_points", "waits for a scan that shows more: the last one has {#0} points where {#1} are needed", "",
    "walls must be in range (lidar.range_max)"};
inline constexpr ProblemKind kLost{"lost", "no pose is published until the robot is found in the map", "", kDriveOn};
inline constexpr ProblemKind kNotFoundYet{"not_found_yet", "waits to be found in the map", "",
                                          "drive slowly on, or give its place: slamctl set-pose"};
// Names: two maps; the others, each behind a comma.
inline constexpr ProblemKind kFloorsAlike{"floors_alike",
                                          "the robot is in one of the maps {0}, {1}{2}, which look alike from here",
                                          "the pose is not valid, or degraded, until it sees what tells them apart",
                                          "drive slowly on to where they differ, or load the right one: slamctl load"};
inline constexpr ProblemKind kFloorOpen{
    "floor_open", "nothing of the floor was in view while it stood, as in a lift: it may be on another one",
    "the pose goes on in the present map", "drive slowly on: it is compared with the maps of store.floors"};
inline constexpr ProblemKind kNoScanPlaced{"no_scan_placed", "waits for a scan that can be placed"};
inline constexpr ProblemKind kScansTurn{"scans_turn",
                                        "scans turn by {#0.1} deg per minute against a gyro that was right at rest",
                                        "the pose goes by wheels and gyro until a rest shows that the gyro has changed",
                                        "does one half of the scan contradict the other half, as where two lidars are "
                                        "merged and one is turned, is the lidar "
                                        "loose, or does it see too little?"};
inline constexpr ProblemKind kNoMatch{"no_match", "waits for scans that match the map: the last {#0} do not",
                                      kOtherSensors, "is the lidar covered, or has the place changed?"};
inline constexpr ProblemKind kWaysDiffer{"ways_differ",
                                         "scans and wheels tell ways that differ by {#0.2} m, one of them is wrong",
                                         "the pose is sure again some metres after they agree",
                                         "was the robot pushed, do its wheels slip, or does someone go along with it?"};
inline constexpr ProblemKind kNextScan{"next_scan", "waits for the next scan that matches", kOtherSensors};
inline constexpr ProblemKind kWheelsRejected{"wheels_rejected", "the wheels contradict the scans and are not heard"};

// LCM. Texts: port or URL, group.
inline constexpr const char* kNotPublished = "nothing is published, pose, map and store go on";
inline constexpr ProblemKind kNoLocalRoute{"no_local_route", "no multicast route", kNotPublished,
                                           "ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo"};
inline constexpr ProblemKind kNoRoute{"no_route", "no multicast route", kNotPublished,
                                      "connect the network, or ip route add 224.0.0.0/4 dev INTERFACE with the "
                                      "interface that goes to the other computers "
                                      "(ip -br addr)"};
inline constexpr ProblemKind kLinkBlocked{
    "link_blocked", "not permitted to send; does a firewall or the unit block udp {0}?", kNotPublished,
    "let udp {0} out (nft list ruleset), and IPAddressAllow={1} in the unit (systemctl cat slamd)"};
inline constexpr ProblemKind kLinkUnheard{"link_unheard", "sent packets do not come back; is udp {0} blocked?",
                                          "commands and samples may not arrive, pose, map and store go on",
                                          "let udp {0} in (nft list ruleset); ip route get {1} names the interface"};
inline constexpr ProblemKind kNoLcmSocket{"no_lcm_socket", "no socket for udp {0}; has another program taken it?",
                                          kNotPublished, "ss -ulnp 'sport = :{0}' names the program"};
inline constexpr ProblemKind kRival{
    "rival", "another program publishes SLAM_POSE on {0} too, a second slamd or a log that is played",
    "who listens gets both poses in turn, slamd goes on",
    "stop one of them (pgrep -a slamd), or give it an lcm.url of its own"};

// Speeds that are asked for. Texts: who sends them, whom slamd follows.
inline constexpr ProblemKind kDriveSenders{"drive_senders", "SLAM_DRIVE comes from {#0} programs ({0})",
                                           "slamd follows the one that began {1}, and stops for a zero of any; one "
                                           "that was stopped is driven again when it has "
                                           "paused for 0.5 s",
                                           "end the programs that are not to drive (ss -uap), or set base.drive_order"};

// The local socket. Texts: path, what the system says, folder.
inline constexpr const char *kNoCommands = "slamd takes no commands there and tries again",
                            *kOtherSocket = "set runtime.socket to another path";
inline constexpr ProblemKind kSocketTooLong{"socket_too_long", "{0}: is longer than a socket's path may be",
                                            kNoCommands, kOtherSocket};
inline constexpr ProblemKind kSocketIsFile{"socket_is_file", "{0}: there is a file that is no socket", kNoCommands,
                                           "remove it, or set runtime.socket to another path"};
inline constexpr ProblemKind kSocketTaken{"socket_taken", "{0}: another program listens there, e.g. a second slamd",
                                          kNoCommands, "stop it, or set runtime.socket to another path"};
inline constexpr ProblemKind kSocketFails{"socket_fails", "{0}: {1}", kNoCommands, kOtherSocket};
inline constexpr ProblemKind kSocketNoFolder{
    "socket_no_folder", "{0}: {1}", kNoCommands,
    "make the folder {2}, writable for slamd, or set runtime.socket to another "
    "path"};
inline constexpr ProblemKind kSocketNoDescriptor{"socket_no_descriptor", "{0}: {1}", kNoCommands,
                                                 "raise the limit of open files (LimitNOFILE= in the unit)"};

// Threads. Texts: name. Numbers: how late [ms], how long it waited for the CPU [s]; memory [MiB] in use, that may be
// locked.
inline constexpr const char* kWhenItStands = "when the robot stands: sudo systemctl restart slamd";
inline constexpr ProblemKind kThreadDead{"thread_dead", "thread {0} does not tick",
                                         "the watchdog is not fed, so that systemd starts slamd anew"};
inline constexpr ProblemKind kGraphDead{
    "graph_dead",
    "thread {0} does not tick: it hangs, so that no loop is closed, no lost robot is "
    "found and no map is stored",
    "the pose goes on", kWhenItStands};
inline constexpr ProblemKind kMapperDead{
    "mapper_dead", "thread {0} does not tick: it hangs, so that the map is drawn no further and not stored",
    "the pose goes on", kWhenItStands};
inline constexpr ProblemKind kCameraDead{"camera_dead", "thread {0} does not tick: its device is stuck",
                                         "slamd goes on without", "pull the camera's plug, and plug it in again"};
inline constexpr ProblemKind kThreadLate{
    "thread_late",
    "thread {0} was late: {#0} ms, and not for want of CPU: slamd was stopped, or a device or the disk kept it waiting",
    "it goes on", "see dmesg"};
inline constexpr ProblemKind kOverloaded{
    "overloaded", "the computer is overloaded: thread {0} has waited {#0.1} s for the CPU", "slamd goes on, but late",
    "end other programs (top), or give it a faster computer"};
inline constexpr const char *kMayWait = "the real-time threads may wait for memory",
                            *kMayLock = "set LimitMEMLOCK=infinity in the unit, or ulimit -l unlimited in a shell";
inline constexpr ProblemKind kNewMemoryNotLocked{
    "new_memory_not_locked", "memory that slamd takes from now on is not locked: only {#1} MiB may be locked", kMayWait,
    kMayLock};
inline constexpr ProblemKind kMemoryNotLocked{
    "memory_not_locked", "memory is not locked: {#0} MiB are in use and only {#1} MiB may be locked", kMayWait,
    kMayLock};
inline constexpr ProblemKind kMemoryRefused{"memory_refused", "memory is not locked: {0}", kMayWait, kMayLock};

// Real-time scheduling. Numbers: priority, limit. Text: the group's file.
inline constexpr const char *kNormalPriority = "slamd goes on at normal priority",
                            *kSchedulesGroups =
                                "sudo sysctl -w kernel.sched_rt_runtime_us=-1, or cpu.rt_runtime_us of the "
                                "group; in a container --cap-add=SYS_NICE --ulimit rtprio=95";
inline constexpr ProblemKind kNoFifo{"no_fifo", "no SCHED_FIFO: {0}", kNormalPriority,
                                     "set the runtime.*_priority keys to 1 to 99"};
inline constexpr ProblemKind kNoFifoByLimit{"no_fifo_by_limit", "no SCHED_FIFO: priority {#0} where the limit is {#1}",
                                            kNormalPriority,
                                            "set LimitRTPRIO=95 in the unit, or ulimit -r 95 in a shell"};
inline constexpr ProblemKind kNoFifoOfGroup{
    "no_fifo_of_group", "no SCHED_FIFO: the kernel gives this control group no real time, cpu.rt_runtime_us is 0",
    kNormalPriority,
    "echo 950000 | sudo tee {0} (and in the groups above it), or sudo sysctl -w kernel.sched_rt_runtime_us=-1"};
inline constexpr ProblemKind kNoFifoByFilter{
    "no_fifo_by_filter",
    "no SCHED_FIFO: the limit allows it, but a system call filter may not (RestrictRealtime=yes in the unit, or a "
    "container), or the kernel schedules real time by groups (CONFIG_RT_GROUP_SCHED) and gives this one none",
    kNormalPriority, kSchedulesGroups};
inline constexpr ProblemKind kNoFifoByKernel{
    "no_fifo_by_kernel",
    "no SCHED_FIFO: the limit allows it, but the kernel schedules real time by "
    "groups (CONFIG_RT_GROUP_SCHED) and gives this one none",
    kNormalPriority, kSchedulesGroups};

// The clock. Numbers: [s] by which it was set.
inline constexpr ProblemKind kClockAhead{"clock_set_ahead", "the wall clock was set ahead by {#0} s",
                                         "the stamps of messages follow it, those of logs go on without the step",
                                         "nothing is to be done"};
inline constexpr ProblemKind kClockBack{
    "clock_set_back", "the wall clock was set back by {#0} s",
    "slamd goes on with stamps that are ahead of it by that, for they never go back",
    "sudo systemctl restart slamd when the robot stands"};

}  // namespace slam::problem
