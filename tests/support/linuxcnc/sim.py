#!/usr/bin/python3
"""An operator: a display of LinuxCNC that homes, moves, and loses the feedback of a joint.

Prints a line of JSON after each thing that it does; then the rows of the sampler, which are whether
the pose is proved and whether motion is enabled, each servo period about the loss.
"""

import json
import subprocess
import time

import hal
import linuxcnc

command, status, errors = linuxcnc.command(), linuxcnc.stat(), linuxcnc.error_channel()
component = hal.component("operator")
component.ready()


def say(what):
    status.poll()
    messages = []
    while message := errors.poll():
        messages.append(message[1].strip())
    line = {
        "after": what,
        "on": status.task_state == linuxcnc.STATE_ON,
        "homed": all(status.homed[:6]),
        "moving": status.interp_state != linuxcnc.INTERP_IDLE,
        "asked": status.position[:3],
        "shown": status.actual_position[:3],
        "proved": hal.get_value("provedkins.proved"),
        "refusals": hal.get_value("provedkins.refusals"),
        "status": hal.get_value("provedkins.status"),
        "messages": messages,
    }
    print("JSON", json.dumps(line), flush=True)
    return line


def turn_on():
    command.state(linuxcnc.STATE_ESTOP_RESET)
    command.wait_complete()
    command.state(linuxcnc.STATE_ON)
    command.wait_complete()


def manual():
    command.mode(linuxcnc.MODE_MANUAL)
    command.wait_complete()
    command.teleop_enable(0)
    command.wait_complete()


def home():
    manual()
    for joint in range(6):
        command.home(joint)
    for _ in range(100):
        time.sleep(0.05)
        status.poll()
        if all(status.homed[:6]):
            break


def move(words):
    command.mode(linuxcnc.MODE_MDI)
    command.wait_complete()
    status.poll()
    begin = status.position[0]
    command.mdi(f"G20 G1 F20 {words}")
    # A busy computer is late.
    for _ in range(200):
        time.sleep(0.05)
        status.poll()
        if status.position[0] > begin + 0.05:
            break


def put_off(by):
    hal.set_p("fb0.in1", str(by))


turn_on()
say("on")
home()
say("home")
move("X3 Y1 Z21 A2 B-1 C3")
say("move")
hal.set_p("sampler.0.enable", "1")
time.sleep(0.05)
put_off(60)
time.sleep(0.5)
rows = subprocess.run(["halsampler", "-n", "400"], capture_output=True, check=True, text=True)
print("JSON", json.dumps({"rows": rows.stdout.splitlines()}), flush=True)
say("lost")
turn_on()
say("on again")
manual()
for joint in range(6):
    command.unhome(joint)
put_off(0)
time.sleep(0.2)
say("unhome")
turn_on()
home()
say("home again")
move("X1")
say("move again")
