// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "problems/problem.hpp"

/// The table of problems: what can be wrong with a device, and with what comes from it.
namespace slam::problem {

inline constexpr ProblemKind kNotOpened{"not_opened", "not opened yet"};
inline constexpr ProblemKind kNotWanted{"not_wanted", "not taken from CAN"};
inline constexpr ProblemKind kOpening{"opening", "opening"};
inline constexpr ProblemKind kWaitsForFrames{"waits_for_frames", "waiting for {0} first frames"};
inline constexpr ProblemKind kStoppedOpening{"stopped_opening", "stopped while opening"};

// Serial ports. Texts: path or group, the kernel's name of the port.
inline constexpr ProblemKind kPortMissing{"port_missing", "no such port", "", "check cable and udev rule"};
inline constexpr ProblemKind kPortGone{"port_gone", "the port is gone: unplugged?"};
inline constexpr ProblemKind kPortInUse{"port_in_use", "the port is in use by another program"};
// Texts: name and process id of the program.
inline constexpr ProblemKind kPortHeld{"port_held", "the port is in use by another program ({0}, {1})", "",
                                       "end that program, a service by sudo systemctl stop {0}"};
inline constexpr ProblemKind kPortIsNone{"port_is_none", "not a serial port", "", "check the path"};
inline constexpr ProblemKind kPortHidden{"port_hidden", "no right to look at {0} (EACCES)", "",
                                         "check its folder's rights"};
inline constexpr const char *kUdevRules =
                                "install slamd's udev rules, then sudo udevadm control --reload && sudo udevadm "
                                "trigger",
                            *kOwnRule =
                                "no rule of slamd's is for a port that is no USB adapter's; end a console on it (sudo "
                                "systemctl disable --now serial-getty@{1}, and take console={1} out of the kernel's "
                                "command line), and give it to group dialout: echo 'KERNEL==\"{1}\", "
                                "GROUP=\"dialout\", MODE=\"0660\"' | sudo tee /etc/udev/rules.d/72-{1}.rules, then "
                                "sudo udevadm control --reload && sudo udevadm trigger",
                            *kNotForPorts =
                                "no right to open the port (EACCES): it belongs to group {0}, which is no "
                                "group for ports",
                            *kShutToGroup =
                                "no right to open the port (EACCES): it belongs to group {0}, which may not "
                                "read and write it";
inline constexpr ProblemKind kPortOfNoGroup{"port_of_no_group", kNotForPorts, "", kUdevRules};
inline constexpr ProblemKind kPortShut{"port_shut", kShutToGroup, "", kUdevRules};
inline constexpr ProblemKind kUartOfNoGroup{"uart_of_no_group", kNotForPorts, "", kOwnRule};
inline constexpr ProblemKind kUartShut{"uart_shut", kShutToGroup, "", kOwnRule};
inline constexpr ProblemKind kPortOfOthers{
    "port_of_others", "no right to open the port (EACCES): it belongs to group {0}", "",
    "sudo usermod -aG {0} $USER and log in again, or SupplementaryGroups={0} in the unit"};
inline constexpr ProblemKind kPortForbidden{
    "port_forbidden", "no right to open the port (EACCES) although group {0} has it: a security module may forbid it",
    "", "see dmesg and aa-status"};
inline constexpr ProblemKind kPortNotListed{
    "port_not_listed",
    "the port may not be opened from here (EPERM): the unit's DevicePolicy or a container's list of devices leaves it "
    "out",
    "", "DeviceAllow={0} rw in the unit (sudo systemctl edit slamd), or docker run --device={0}"};
inline constexpr ProblemKind kNoDescriptors{"no_descriptors", "the port cannot be opened: no file descriptors are left",
                                            "", "restart slamd, and raise LimitNOFILE"};
inline constexpr ProblemKind kAdapterDead{"adapter_dead",
                                          "the port cannot be opened (EIO): its adapter does not answer", "",
                                          "pull its plug, and plug it in again"};
inline constexpr ProblemKind kPortNotOpened{"port_not_opened", "the port cannot be opened: {0}", "",
                                            "check its path and cable, dmesg"};
inline constexpr ProblemKind kPortUnknown{"port_unknown",
                                          "libserialport does not find the port, for which it needs /proc "
                                          "and /sys",
                                          "", "mount them"};
inline constexpr ProblemKind kPortRefusesSettings{"port_refuses_settings", "the port refuses its settings", "",
                                                  "check the baud rate"};

// Devices on the network. Texts: the address.
inline constexpr ProblemKind kTcpAddressBad{"tcp_address_bad", "{0} is no address of a device on the network", "",
                                            "write it as tcp://192.168.0.10:10940, in numbers"};
inline constexpr ProblemKind kTcpRefused{
    "tcp_refused", "{0} refuses the connection", "slamd goes on without, and tries again",
    "check the number behind the colon; most lidars take one program at a time: end the other one"};
inline constexpr ProblemKind kTcpNoWay{
    "tcp_no_way", "no way leads to {0}", "slamd goes on without, and tries again",
    "check the network cable, and give this computer an address in the lidar's network (ip address)"};
inline constexpr ProblemKind kTcpNoReply{"tcp_no_reply", "{0} does not reply", "slamd goes on without, and tries again",
                                         "check the lidar's supply and cable, and its address (ping)"};
inline constexpr ProblemKind kTcpClosed{
    "tcp_closed", "{0} has closed the connection", "slamd goes on without, and tries again",
    "most lidars take one program at a time: end the other one, else check the lidar's supply"};
inline constexpr ProblemKind kTcpSilent{"tcp_silent", "{0} takes the connection, but sends nothing of this lidar",
                                        "slamd goes on without, and tries again",
                                        "check lidar.driver and lidar.port; another program may be connected to it"};

// Another device on the port. Texts: its name, the keys of the device that is expected and of this one, or how its
// packets begin. Numbers [bit/s]: as it answers, as configured.
inline constexpr ProblemKind kOtherBaud{"other_baud",
                                        "{0} answers on this port at {#0} bit/s, not at {#1}: nothing can be read", "",
                                        "set {1}.baud = {#0}"};
inline constexpr ProblemKind kOtherDevice{"other_device", "{0} is on this port: the {1} is missed",
                                          "slamd goes on without",
                                          "are the two cables swapped? exchange {1}.port and {2}.port"};
inline constexpr ProblemKind kForeignDevice{"foreign_device", "{0} is on this port ({#0} bit/s{1})",
                                            "slamd cannot read it and goes on without",
                                            "set the right port: slamctl doctor lists them"};
// Texts: its name, how its packets begin, the values of lidar.driver for it.
inline constexpr ProblemKind kForeignLidar{"foreign_lidar", "{0} is on this port ({#0} bit/s{1})",
                                           "slamd is set for another lidar and goes on without",
                                           "set lidar.driver = {2} for it"};

// Texts: its name, how its packets begin, the value of base.driver for it.
inline constexpr ProblemKind kForeignBase{"foreign_base", "{0} is on this port ({#0} bit/s{1})",
                                          "slamd is set for another base and goes on without",
                                          "set base.driver = \"{2}\" for it"};

// Texts: its name, how its packets begin, the value of imu.driver for it.
inline constexpr ProblemKind kForeignImu{"foreign_imu", "{0} is on this port ({#0} bit/s{1})",
                                         "slamd is set for another IMU and goes on without",
                                         "set imu.driver = \"{2}\" for it"};

// Lidars.
inline constexpr ProblemKind kLidarUnheard{"lidar_unheard", "port present, but nothing comes", "",
                                           "check the lidar's 5 V supply and its data line, and whether it turns"};
inline constexpr ProblemKind kLidarNoPackets{"lidar_no_packets", "bytes come, but no packet of this lidar among them",
                                             "", "check lidar.driver and lidar.baud, cable and ground"};
inline constexpr ProblemKind kLidarSearched{"lidar_searched", "looking for the lidar that is on this port"};
inline constexpr ProblemKind kLidarNotFound{
    "lidar_not_found", "something sends on this port, but nothing of a lidar that can be found by itself", "",
    "set lidar.driver to the lidar's model, check cable and ground"};
inline constexpr ProblemKind kLidarUndecoded{"lidar_undecoded", "bytes come, but no answer among them", "",
                                             "check the baud rate"};
inline constexpr ProblemKind kLidarUnanswered{"lidar_unanswered", "port present, but no answer", "",
                                              "check baud rate and 5 V supply"};
inline constexpr ProblemKind kLidarSilent{"lidar_silent", "port present, no answer", "", "check 5 V supply and cable"};
inline constexpr ProblemKind kLidarIdle{"lidar_idle", "port present, health OK", "", "check 5 V supply and motor"};
// Text: what it reports of its state.
inline constexpr ProblemKind kLidarStopped{"lidar_stopped",
                                           "the lidar answers, but its scan has stopped; it reports: {0}",
                                           "slamd begins its scan anew", "check its supply, see its manual"};
inline constexpr ProblemKind kLidarError{"lidar_error", "port present, the lidar reports a hardware error", "",
                                         "see its manual"};
inline constexpr ProblemKind kLidarErrorStays{
    "lidar_error_stays", "the lidar reports a hardware error even after resets", "", "see its manual"};
inline constexpr ProblemKind kLidarUnknown{"lidar_unknown", "the lidar tells its health but not what it is", "",
                                           "check its cable"};
inline constexpr ProblemKind kLidarRestarted{"lidar_restarted", "the lidar restarted by itself in mid-scan", "",
                                             "check its 5 V supply"};
inline constexpr ProblemKind kLidarHeadStands{"lidar_head_stands", "measurements come, but of no whole turn", "",
                                              "the head does not turn, check its belt"};
inline constexpr ProblemKind kLidarMotorStands{"lidar_motor_stands", "scan accepted, but no data", "",
                                               "the motor does not turn, check its plug and 5 V supply"};
inline constexpr ProblemKind kLidarGarbage{"lidar_garbage", "bytes come, but no measurements among them", "",
                                           "check cable and ground, and scan_mode"};
inline constexpr ProblemKind kLidarNoScan{"lidar_no_scan", "the lidar does not start its scan", "",
                                          "check its 5 V supply"};
inline constexpr ProblemKind kLidarSpinsUp{"lidar_spins_up", "waiting for the motor's speed"};
inline constexpr ProblemKind kLidarWarns{"lidar_warns", "works, but the lidar warns of its health", "",
                                         "clean its window, see its manual"};
inline constexpr ProblemKind kLidarHalved{
    "lidar_halved", "a turn has more measurements than a scan holds (4080)",
    "every second one is used, evenly over the turn, and slamd goes on with these",
    "let the motor turn faster, or choose a sparser lidar.scan_mode"};
inline constexpr ProblemKind kLidarThinned{"lidar_thinned",
                                           "a turn has many more measurements than a scan holds (4080)",
                                           "one of several is used, evenly over the turn, and slamd goes on with these",
                                           "let the motor turn faster: check its supply and belt"};
inline constexpr ProblemKind kLidarStuck{
    "lidar_stuck", "every turn shows the same ranges although the robot moves: the lidar is stuck", "",
    "pull its plug"};

// HandsFree board.
inline constexpr ProblemKind kBoardOpening{"board_opening", "waiting for the board's first answer"};
inline constexpr ProblemKind kBoardUndecoded{"board_undecoded", "port present, but what comes is not RoboLink", "",
                                             "check baud rate and cable"};
inline constexpr ProblemKind kBoardUnanswered{"board_unanswered", "port present, but the board never answers", "",
                                              "check baud rate and power"};
inline constexpr ProblemKind kBoardGarbage{"board_garbage", "the board's answers cannot be read", "",
                                           "check baud rate and cable"};
inline constexpr ProblemKind kBoardSilent{"board_silent", "the board does not answer", "", "check its power"};
inline constexpr ProblemKind kBoardLate{"board_late", "the board's answers come too late", "",
                                        "is something else on its link (USB hub, cable)?"};
inline constexpr ProblemKind kBoardFrozen{"board_frozen", "the board answers, but renews nothing any more", "",
                                          "restart it"};
inline constexpr ProblemKind kBoardNoMileage{"board_no_mileage", "the board answers, but not with mileage", "",
                                             "restart it"};
inline constexpr ProblemKind kBoardImuFrozen{"board_imu_frozen", "the board answers, but its IMU values never change",
                                             "", "restart it"};
inline constexpr ProblemKind kBoardImuOffline{"board_imu_offline", "the board says that its IMU is offline", "",
                                              "restart the board, and check its IMU's cable"};
inline constexpr ProblemKind kBoardBodyRadius{
    "board_body_radius", "base: the board believes in another body radius (half the track) than configured",
    "slamd goes by the configuration", "which one is right? set base.half_track, or the board's"};
inline constexpr ProblemKind kBoardWheelRadius{
    "board_wheel_radius", "base: the board believes in another wheel radius than configured",
    "slamd goes by the configuration", "which one is right? set base.wheel_radius, or the board's"};
inline constexpr ProblemKind kBoardOtherBase{"board_other_base",
                                             "base: the board drives another type of base than configured",
                                             "its wheels are read wrongly", "set base.kinematics"};

// Bases of the table. Texts: name of the make. Numbers of the geometry: wheel radius and half track [m] as configured,
// and by the maker.
inline constexpr ProblemKind kBaseUndecoded{"base_undecoded", "port present, but what comes is not of {0}", "",
                                            "check base.driver, base.baud and the cable"};
inline constexpr ProblemKind kBaseLifted{"base_lifted",
                                         "a wheel hangs in the air: the base is lifted, or stands on an edge",
                                         "slamd takes the wheels for no motion, maps nothing, and drives the base only "
                                         "by a SLAM_DRIVE given after it stands",
                                         "put it down on the floor"};
inline constexpr ProblemKind kBaseLeftSafeMode{
    "base_left_safe_mode", "the base has stopped by itself: a wheel dropped, an edge or its charger came, or a button",
    "slamd drives it by a new SLAM_DRIVE only", "clear its way, and drive on"};
inline constexpr ProblemKind kBaseBumped{"base_bumped", "a bumper of the base is pressed",
                                         "slamd drives on as SLAM_DRIVE asks",
                                         "drive back, or free what it has run into"};
inline constexpr ProblemKind kBaseNoGyro{"base_no_gyro", "{0} sends wheels, but no turn rate",
                                         "slamd goes on without a gyro",
                                         "check the gyro's cable, or set imu.driver to the gyro that there is"};
inline constexpr ProblemKind kBaseGeometry{
    "base_geometry",
    "base: base.wheel_radius is {#0.4} m and base.half_track {#1.4} m, but {0} has {#2.4} m and {#3.4} m",
    "slamd goes by the configuration",
    "set base.wheel_radius = {#2.4} and base.half_track = {#3.4}, or to what slam-calibrate measures"};

// IMUs of the table. Texts: name of the make, what to look at where it is silent besides its power, outputs to switch
// on.
inline constexpr ProblemKind kImuUndecoded{"imu_undecoded", "port present, but what comes is not of {0}", "",
                                           "check imu.driver, imu.baud and the port"};
inline constexpr ProblemKind kImuUnanswered{"imu_unanswered", "port present, but the IMU is silent", "",
                                            "check its power{1}"};
inline constexpr ProblemKind kImuGarbage{"imu_garbage", "the IMU's frames cannot be read", "",
                                         "check baud rate and cable"};
inline constexpr ProblemKind kImuSilent{"imu_silent", "the IMU sends nothing", "", "check its power{1}"};
inline constexpr ProblemKind kImuNoRate{"imu_no_rate", "{0} sends frames, but no turn rates among them", "",
                                        "set its output with its maker's program: {2}"};
inline constexpr ProblemKind kImuSenseless{"imu_senseless",
                                           "the IMU's frames have values that no sensor measures, or none", "",
                                           "restart it, see the rejects"};
inline constexpr ProblemKind kImuFrozen{"imu_frozen", "the IMU sends frames, but its values never change", "",
                                        "restart it"};
inline constexpr ProblemKind kImuNoAcceleration{"imu_no_acceleration", "the IMU sends acceleration seldom or never",
                                                "slamd goes on with its turn rate alone", "set its output"};
// IMUs that the kernel reads. Texts: what imu.port wants; name of the chip.
inline constexpr ProblemKind kIioMissing{
    "iio_missing", "the kernel has no IMU {0}", "",
    "set imu.port to its name or folder, grep . /sys/bus/iio/devices/*/name lists them; else load its kernel driver"};
inline constexpr ProblemKind kIioNoGyro{"iio_no_gyro", "{0} has no gyro of three axes", "",
                                        "set imu.port to another device: grep . /sys/bus/iio/devices/*/name"};
inline constexpr ProblemKind kIioUnread{"iio_unread", "the kernel cannot read {0}", "",
                                        "check its wires and its bus: sudo dmesg"};

// CAN. Texts: interface.
inline constexpr ProblemKind kCanGone{"can_gone", "interface {0} is gone: adapter unplugged?"};
inline constexpr ProblemKind kCanDown{"can_down", "{0} is down", "", "ip link set {0} up"};
inline constexpr ProblemKind kCanBusOff{"can_bus_off", "{0} is bus-off", "", "check wiring and termination"};
inline constexpr ProblemKind kCanPassive{"can_passive", "{0} is error-passive", "",
                                         "check wiring, termination and bit rate"};
inline constexpr ProblemKind kCanUnsupported{"can_unsupported", "the kernel has no CAN", "", "modprobe can-raw"};
inline constexpr ProblemKind kCanRefused{"can_refused", "the system refuses a CAN socket on {0}", "",
                                         "see journalctl -u slamd -n 20 and dmesg"};
inline constexpr ProblemKind kCanBlocked{
    "can_blocked", "{0} takes no frames, although frames come in",
    "the wheels keep their last speeds until the drives' own watchdogs stop them; slamd goes on trying",
    "if they turn, cut the drives' power; plug the adapter in anew, or sudo ip link set {0} down && sudo ip link set "
    "{0} "
    "up"};
inline constexpr ProblemKind kCanNoImu{"can_no_imu", "no frames of the IMU (005, 032, 034)", "",
                                       "check its power and the bit rate"};
inline constexpr ProblemKind kCanNoRate{"can_no_rate", "the IMU sends no rate of turn (032)", "", "set its output"};
inline constexpr ProblemKind kCanNoAcceleration{"can_no_acceleration", "the IMU sends no acceleration (034)",
                                                "slamd goes on with its turn rate alone", "set its output"};
inline constexpr ProblemKind kCanNoTime{"can_no_time", "the IMU sends no sample time (005)",
                                        "slamd takes its readings with the stamps of their arrival", "set its output"};
inline constexpr ProblemKind kCanRareTime{
    "can_rare_time", "the IMU sends fewer sample times (005) than turn rates (032)",
    "slamd takes its readings with the stamps of their arrival", "set both to one rate"};
inline constexpr ProblemKind kCanRareAcceleration{
    "can_rare_acceleration", "the IMU sends fewer accelerations (034) than turn rates (032)",
    "slamd takes each turn rate without acceleration", "set both to one rate"};
inline constexpr ProblemKind kCanImuSenseless{"can_imu_senseless", "the IMU's frames do not make samples", "",
                                              "see the rejects"};
inline constexpr ProblemKind kCanImuFrozen{"can_imu_frozen", "the IMU answers, but its values never change", "",
                                           "restart it"};
inline constexpr ProblemKind kWheelsSenseless{"wheels_senseless", "what the wheels send is no motion of a wheel", "",
                                              "see the rejects"};

// Of one wheel. Texts: its side, what its drive reports, interface. Numbers: node of its drive, identifiers of its
// commands set axis state, clear errors and controller mode; or the period [ms] of its estimates.
inline constexpr const char* kStops = "slamd stops both wheels until both drives obey and a new SLAM_DRIVE comes";
inline constexpr ProblemKind kNoWheels{
    "no_wheels", "no frames of the left wheel (node 0x{#0x2}), nor of the right wheel (node 0x{#1x2})", "",
    "check their power, the bit rate and can.left_node, can.right_node"};
inline constexpr ProblemKind kNoFrames{"no_frames", "no frames of the {0} wheel (node 0x{#0x2})", "",
                                       "check the drive's power and its plug"};
inline constexpr ProblemKind kNoFramesStops{"no_frames_stops", kNoFrames.cause, kStops, kNoFrames.fix};
inline constexpr ProblemKind kNoEstimates{
    "no_estimates", "the {0} wheel (node 0x{#0x2}) sends heartbeats, but no encoder estimates", "", "set their rate"};
inline constexpr ProblemKind kBadEstimates{
    "bad_estimates", "the {0} wheel (node 0x{#0x2}) sends encoder estimates that are no numbers",
    "slamd uses none of them and goes on without",
    "restart the drive, calibrate its encoder anew (odrivetool: dump_errors), and check its cable"};
inline constexpr ProblemKind kNoHeartbeat{"no_heartbeat", "no heartbeat of the {0} wheel (node 0x{#0x2})", "",
                                          "set the drive's heartbeat_msg_rate_ms to 100"};
inline constexpr ProblemKind kNoHeartbeatStops{"no_heartbeat_stops", kNoHeartbeat.cause, kStops, kNoHeartbeat.fix};
inline constexpr ProblemKind kWheelFrozen{
    "wheel_frozen", "the {0} wheel (node 0x{#0x2}) says that it turns, but its position never changes", "",
    "check its encoder"};
inline constexpr ProblemKind kNotArmed{"not_armed",
                                       "the {0} wheel (node 0x{#0x2}) is not in closed loop: it obeys no commands", "",
                                       "arm it: cansend {2} {#1x3}#08000000"};
inline constexpr ProblemKind kNotArmedStops{"not_armed_stops", kNotArmed.cause, kStops, kNotArmed.fix};
inline constexpr ProblemKind kNotFollowing{"not_following",
                                           "the {0} wheel (node 0x{#0x2}) does not turn while the other one does as it "
                                           "is asked to: it is blocked, or its drive "
                                           "is not in velocity control",
                                           "slamd stops both wheels until SLAM_DRIVE has paused for 2 s",
                                           "free the wheel, cansend {2} {#3x3}#0200000001000000"};
inline constexpr ProblemKind kSharedId{
    "shared_id", "the heartbeat of the {0} wheel (node 0x{#0x2}) has the IMU's quaternion's id",
    "slamd goes on with the wheel alone", "switch the quaternion off, or give the drive node 16"};
inline constexpr ProblemKind kSlowEstimates{"slow_estimates", "{0} wheel: encoder estimates come every {#0} ms",
                                            "slamd goes on with those that agree, the pose is coarser",
                                            "set encoder_msg_rate_ms to 10 to 50"};
inline constexpr ProblemKind kAxisError{"axis_error", "{0} wheel: axis error {1}", "",
                                        "remove the cause, then cansend {2} {#2x3}# and cansend {2} {#1x3}#08000000"};
inline constexpr ProblemKind kAxisErrorStops{"axis_error_stops", kAxisError.cause, kStops, kAxisError.fix};

// Of one wheel's VESC. Texts: its side. Numbers: its id, temperature of its transistors [deg C]; or the period [ms].
inline constexpr ProblemKind kVescNoEstimates{
    "vesc_no_estimates", "the {0} wheel (VESC {#0}) does not send both STATUS and STATUS_5", "",
    "in VESC Tool: App Settings, General, CAN status messages: 1, 4 and 5 at 50 Hz"};
inline constexpr ProblemKind kVescNotFollowing{
    "vesc_not_following",
    "the {0} wheel (VESC {#0}) does not turn while the other one does as it is asked to: it is blocked, or its "
    "controller has a fault",
    "slamd stops both wheels until SLAM_DRIVE has paused for 2 s",
    "free the wheel; in VESC Tool: Terminal, faults, and Motor Settings, PID Controllers, Minimum ERPM"};
inline constexpr ProblemKind kVescSlow{"vesc_slow", "{0} wheel: STATUS_5 comes every {#0} ms",
                                       "slamd goes on with those that agree, the pose is coarser",
                                       "in VESC Tool: App Settings, General, CAN status rate: 50 Hz"};
inline constexpr ProblemKind kVescAway{"vesc_away",
                                       "the {0} wheel's VESC ({#0}) does not answer over the CAN of the other one",
                                       "slamd stops both wheels, and has no motion of them",
                                       "check the CAN cable between them, its power, and its id against can.{0}_node"};
inline constexpr ProblemKind kVescFault{"vesc_fault", "the {0} wheel's VESC ({#0}) has the fault {#1}",
                                        "slamd stops both wheels until it has gone",
                                        "in VESC Tool: Terminal, faults; remove the cause"};
inline constexpr ProblemKind kVescHot{"vesc_hot", "the transistors of the {0} wheel's VESC have {#1} degrees",
                                      "as delivered it limits its current from 85 on: the wheel may become slow",
                                      "let it cool, and cool it better"};

// Depth camera. Texts: what is named in the configuration, what there is.
inline constexpr ProblemKind kNoOpenni{"no_openni", "OpenNI2 does not start", "",
                                       "is libopenni2-0 installed with its drivers?"};
inline constexpr ProblemKind kCameraReset{"camera_reset", "the camera sends no images: resetting it on the USB"};
inline constexpr ProblemKind kCameraSought{"camera_sought", "looking for the camera", "",
                                           "if that lasts, check its cable"};
inline constexpr ProblemKind kCameraOpening{"camera_opening", "waiting for the first image"};
inline constexpr ProblemKind kCameraMissing{"camera_missing", "no camera found", "", "check plug and power"};
inline constexpr ProblemKind kCameraHidden{"camera_hidden", "a camera is on the USB, but OpenNI2 does not find it", "",
                                           "check the udev rules"};
inline constexpr ProblemKind kCameraNameMissing{
    "camera_name_missing", "there is no camera {0} (depth.uri)", "the map goes on without",
    "there is {1}: set depth.uri to it, or leave it empty for the first one"};
inline constexpr ProblemKind kCameraNotOpened{"camera_not_opened", "the camera cannot be opened", "",
                                              "check rights, and other programs using it"};
inline constexpr ProblemKind kCameraNoStream{"camera_no_stream", "the device has no depth stream", "",
                                             "set depth.uri to a depth camera"};
inline constexpr ProblemKind kCameraNotStarted{"camera_not_started", "the camera does not start its depth stream", "",
                                               "USB 2 port, enough bandwidth?"};
inline constexpr ProblemKind kCameraNoMode{"camera_no_mode", "the camera does not offer {0}", "the map goes on without",
                                           "set depth.width, height and rate to one of {1}"};
inline constexpr ProblemKind kCameraOtherMode{"camera_other_mode", "the camera did not take the mode that it was given",
                                              "", "set depth.width, height and rate to one that it offers"};
inline constexpr ProblemKind kCameraOtherFormat{"camera_other_format", "the depth is not in the 1 mm format", "",
                                                "take another camera or recording"};
inline constexpr ProblemKind kCameraNoView{"camera_no_view", "the camera tells no field of view", "",
                                           "take another camera or recording"};
inline constexpr ProblemKind kCameraUnplugged{"camera_unplugged", "the camera was unplugged", "", "plug it in again"};
inline constexpr ProblemKind kCameraFrozen{"camera_frozen",
                                           "no image for 0.9 s: the camera has frozen or left the bus"};
inline constexpr ProblemKind kCameraUnread{"camera_unread", "an image cannot be read"};
inline constexpr ProblemKind kImagesMissing{"images_missing", "there is no such recording", "", "see depth.uri"};
inline constexpr ProblemKind kImagesNotOpened{"images_not_opened", "the recording cannot be opened", "",
                                              "see depth.uri"};
inline constexpr ProblemKind kImagesNotPlayed{"images_not_played", "the recording cannot be played image by image", "",
                                              "see depth.uri"};
inline constexpr ProblemKind kImagesOver{"images_over", "the recording is over", "",
                                         "start slamd again to play it anew"};
inline constexpr ProblemKind kImagesNotStored{"images_not_stored", "the recording does not start", "",
                                              "can depth.record be written?"};
inline constexpr ProblemKind kImagesNotRecorded{"images_not_recorded", "the images cannot be recorded",
                                                "they are used all the same", "can the file be written?"};
inline constexpr ProblemKind kCameraNotMounted{"camera_not_mounted", "images are not used", "",
                                               "measure the camera's height above the floor and set depth.z"};
inline constexpr ProblemKind kCameraStuck{"camera_stuck", "every image is the same: the camera is stuck", "",
                                          "pull its plug"};
inline constexpr ProblemKind kImagesWrongSize{"images_wrong_size", "images of a wrong size are not used"};
inline constexpr ProblemKind kImagesEmpty{"images_empty", "images without depth are not used", "",
                                          "is the camera covered, or blinded by the sun?"};
inline constexpr ProblemKind kImagesTilted{
    "images_tilted", "images are not used, the floor is not where [depth] puts it", "", "check pitch, roll and z"};
inline constexpr ProblemKind kImagesBelowFloor{
    "images_below_floor", "images are not used, they show much below the floor", "", "check pitch, roll and z"};

// Of any device. Numbers [Hz]: measured, expected, lost or damaged.
inline constexpr ProblemKind kDamaged{
    "damaged", "{#0.1} Hz where {#1.1} Hz are expected, for {#2.1} a second are lost or damaged on the line",
    "slamd goes on with those that are whole",
    "check the cable, its plugs and its ground, or take another USB socket without a hub"};
inline constexpr ProblemKind kSlow{"slow", "{#0.1} Hz where {#1.1} Hz are expected, and nothing is damaged on the line",
                                   "slamd goes on with what comes",
                                   "check at which rate the device is set to send, and its power"};
inline constexpr ProblemKind kStarved{"starved", "the computer is overloaded", "", "end other programs (top)"};
inline constexpr ProblemKind kSilent{"silent", "port present, but silent", "", "pull its plug"};

// Over LCM. Texts: channel. Numbers [s]: age of the stamps.
inline constexpr ProblemKind kLcmOpening{"lcm_opening", "waiting for messages on LCM"};
inline constexpr ProblemKind kLcmSilent{"lcm_silent", "nobody sends it over LCM", "",
                                        "start the program that sends it; both need one lcm.url"};
inline constexpr ProblemKind kStampsOld{
    "stamps_old", "stamps are {#0s} s old: use slam-replay for a log; else the clocks differ",
    "slamd goes by the difference", "set the sender's clock: timedatectl set-ntp true"};
inline constexpr ProblemKind kStampsAhead{"stamps_ahead", "stamps are {#0s} s ahead: the clocks differ",
                                          "slamd goes by the difference",
                                          "set the sender's clock: timedatectl set-ntp true"};

// Texts: channel, what is wrong with the messages, the fix.
inline constexpr ProblemKind kRefused{"refused", "{0} is rejected: {1}", "slamd goes on without such messages", "{2}"};

}  // namespace slam::problem
