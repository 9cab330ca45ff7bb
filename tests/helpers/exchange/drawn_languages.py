"""How targets are written in each language, and which joints its controller takes to what stands there.

The rules are written anew from the bytes of the file; they know neither the readers nor the rules of the
product. Programs that move from target to target come to each from a configuration some degrees away.
"""

import json
import re

import numpy as np

from tests.helpers.exchange import other_controller as other
from tests.helpers.exchange.written_rotations import (
    from_quaternion,
    from_vector,
    from_zyx,
    quaternion,
    vector,
    zyx,
)

_NUMBER = r"(-?[0-9.]+(?:[eE][-+]?[0-9]+)?)"
_NONE = "9E9,9E9,9E9,9E9,9E9,9E9"
_AWAY = 0.1  # rad, of the joints before


def numbers(text):
    return [float(number) for number in re.findall(_NUMBER, text)]


def _read(pattern, data):
    return np.array([numbers(b" ".join(found).decode()) for found in re.findall(pattern, data)])


def _frame(x, y, z, angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0, s, x], [0, 1.0, 0, y], [-s, 0, c, z], [0, 0, 0, 1.0]])


_TOOL = _frame(40.0, -10.0, 120.0, 0.7)
_OBJECT = _frame(300.0, 150.0, -80.0, 0.4)


def _written(robot, joints):
    """Poses of the tool in the work object."""
    return np.linalg.inv(_OBJECT) @ other.transform(robot, joints) @ _TOOL


def _flange(x, rotation):
    return _OBJECT @ _pose(x, rotation) @ np.linalg.inv(_TOOL)


def _pose(x, rotation):
    found = np.tile(np.eye(4), (len(x), 1, 1))
    found[:, :3, :3], found[:, :3, 3] = rotation, x
    return found


def _of_bits(robot, pose, bits):
    """Of all answers those behind axis 1, behind the lower arm and with joint 5 negative as bits say."""
    answers = other.spherical_answers(robot, pose)
    found = np.full((len(pose), 6), np.nan)
    for k in range(8):
        same = (other.posture(robot, np.nan_to_num(answers[:, k])) == bits).all(axis=1)
        same &= np.isfinite(answers[:, k]).all(axis=1)
        found[same] = answers[same, k]
    return found


def _within_limits(robot, joints):
    """Axes whose range is not even about zero, such as axis 2 of a KUKA, in the turn that is in it."""
    if robot.joint_limits is None:
        return joints
    middle = np.array([(r.lower_rad + r.upper_rad) / 2 for r in robot.joint_limits])
    return joints - other.FULL * np.round((joints - middle) / other.FULL)


# ABB -------------------------------------------------------------------------------------------------------
def rapid(robot, joints):
    pose, quadrant = _written(robot, joints), np.floor(joints / other.QUARTER).astype(int)
    cfx = other.posture(robot, joints) @ [4, 2, 1]
    lines = [
        f"  PERS tooldata t:=[TRUE,{_rapid_pose(_TOOL)},[1,[0,0,1],[1,0,0,0],0,0,0]];",
        f'  PERS wobjdata w:=[FALSE,TRUE,"",{_rapid_pose(_OBJECT)},[[0,0,0],[1,0,0,0]]];',
    ]
    for k, (one, quarter) in enumerate(zip(pose, quadrant, strict=True)):
        conf = f"{quarter[0]},{quarter[3]},{quarter[5]},{cfx[k]}"
        lines.append(f"  CONST robtarget p{k}:={_rapid_pose(one)[:-1]},[{conf}],[{_NONE}]];")
    moves = [f"    Move{'JL'[k % 2]} p{k},v100,fine,t\\WObj:=w;" for k in range(len(joints))]
    body = "\n".join([*lines, "  PROC main()", *moves, "  ENDPROC"])
    return f"MODULE M\n{body}\nENDMODULE\n".encode()


def _rapid_pose(one):
    x = ",".join(f"{v:.6f}" for v in one[:3, 3])
    q = ",".join(f"{v:.10f}" for v in quaternion(one[:3, :3]))
    return f"[[{x}],[{q}]]"


def taken_by_abb(robot, data, drawn):
    found = rb"robtarget p[0-9]+:=\[\[([^\]]*)\],\[([^\]]*)\],\[([^\]]*)\]"
    read = _read(found, data)
    conf = read[:, 7:].astype(int)
    bits = np.stack([conf[:, 3] >> 2 & 1, conf[:, 3] >> 1 & 1, conf[:, 3] & 1], axis=1).astype(bool)
    taken = _within_limits(robot, _of_bits(robot, _flange(read[:, :3], from_quaternion(read[:, 3:7])), bits))
    for axis, place in ((0, 0), (3, 1), (5, 2)):  # exactly the quarter that is named
        turn = np.floor(taken[:, axis] / other.QUARTER)
        whole = (conf[:, place] - turn) / 4
        taken[:, axis] += other.FULL * np.where(whole == np.round(whole), whole, np.nan)
    return taken


def rapid_joints(robot, joints):
    lines = [
        "  CONST jointtarget p{}:=[[{}],[{}]];".format(k, ",".join(f"{v:.9f}" for v in one), _NONE)
        for k, one in enumerate(np.degrees(joints))
    ]
    moves = [f"    MoveAbsJ p{k},v100,fine,tool0;" for k in range(len(joints))]
    return "\n".join(["MODULE M", *lines, "  PROC main()", *moves, "  ENDPROC", "ENDMODULE", ""]).encode()


def taken_as_joints(robot, data, drawn):
    """Joints of a file, if they leave the arm in the posture of the drawn ones."""
    taken = np.radians(_read(rb"jointtarget p[0-9]+:=\[\[([^\]]*)()\]", data))
    same = (other.posture(robot, taken) == other.posture(robot, drawn)).all(axis=1)
    return np.where(same[:, None], taken, np.nan)


# KUKA ------------------------------------------------------------------------------------------------------
def krl(robot, joints):
    turn = (joints < 0) @ (1 << np.arange(6))
    status = other.posture(robot, joints)[:, :2] @ [1, 2]
    lines = []
    for k, one in enumerate(_written(robot, joints)):
        bits = f"{turn[k]}" if k % 2 else f"'B{turn[k]:06b}'"
        lines.append(f"DECL E6POS XP{k}={{{_krl_pose(one)},S {status[k]},T {bits},E1 0.0}}")
    moves = [f"PTP XP{k}" for k in range(len(joints))]
    head = f"DEF M( )\n$TOOL={{{_krl_pose(_TOOL)}}}\n$BASE={{{_krl_pose(_OBJECT)}}}"
    return "\n".join([head, *lines, *moves, "END", ""]).encode()


def _krl_pose(one):
    x, y, z = one[:3, 3]
    a, b, c = zyx(one[:3, :3])
    return f"X {x:.6f},Y {y:.6f},Z {z:.6f},A {a:.9f},B {b:.9f},C {c:.9f}"


def taken_by_kuka(robot, data, drawn):
    entry = rb"E6POS XP[0-9]+=\{X (.*?),Y (.*?),Z (.*?),A (.*?),B (.*?),C (.*?),S ([0-9]+),T (.*?),E1"
    found = re.findall(entry, data)
    read = np.array([[float(v) for v in group[:6]] for group in found])
    turn = [int(g[7][2:-1], 2) if g[7].startswith(b"'B") else int(g[7]) for g in found]
    status = np.array([int(g[6]) for g in found])
    negative = (np.array(turn)[:, None] >> np.arange(6) & 1).astype(bool)
    bits = np.stack([status & 1, status >> 1 & 1, negative[:, 4]], axis=1).astype(bool)
    taken = _within_limits(robot, _of_bits(robot, _flange(read[:, :3], from_zyx(read[:, 3:])), bits))
    wrong = (taken < 0) != negative
    return taken + np.where(wrong, np.where(negative, -other.FULL, other.FULL), 0.0)


# FANUC, Yaskawa, a milling machine --------------------------------------------------------------------------
def fanuc(robot, joints):
    """With turns of joints 1, 4 and 6; the words name the posture of the drawn joints."""
    turns = np.round(joints[:, [0, 3, 5]] / other.FULL).astype(int)
    words = [f"N U T, {first}, {second}, {third}" for first, second, third in turns]
    blocks, moves = [], []
    for k, one in enumerate(other.transform(robot, joints)):
        r, p, w = zyx(one[:3, :3])
        x, y, z = one[:3, 3]
        blocks.append(
            f"P[{k}]{{\n   GP1:\n\tUF : 0, UT : 0,\tCONFIG : '{words[k]}',\n"
            f"\tX = {x:.3f} mm,\tY = {y:.3f} mm,\tZ = {z:.3f} mm,\n"
            f"\tW = {w:.3f} deg,\tP = {p:.3f} deg,\tR = {r:.3f} deg\n}};"
        )
        moves.append(f"   {k + 1}:J P[{k}] 20% FINE ;")
    return "\n".join(["/PROG M", "/MN", *moves, "/POS", *blocks, "/END", ""]).encode()


def taken_by_fanuc(robot, data, drawn):
    entry = (
        rb"'N U T, (.*?)',\n\tX = (.*?) mm,\tY = (.*?) mm,\tZ = (.*?) mm,\n"
        rb"\tW = (.*?) deg,\tP = (.*?) deg,\tR = (.*?) deg"
    )
    read = _read(entry, data)
    pose = _pose(read[:, 3:6], from_zyx(read[:, [8, 7, 6]]))
    taken = _within_limits(robot, _of_bits(robot, pose, other.posture(robot, drawn)))
    taken[:, [0, 3, 5]] = other.turned_to(taken[:, [0, 3, 5]], 0.0) + other.FULL * read[:, :3]
    return taken


def inform(robot, joints):
    """With the flags of axes 4, 6 and 1 beyond half a turn."""
    lines = ["/JOB", "//NAME M", "//POS", "///TOOL 0", "///POSTYPE ROBOT", "///RECTAN"]
    beyond = (np.abs(joints[:, [3, 5, 0]]) > np.pi).astype(int)
    for k, one in enumerate(other.transform(robot, joints)):
        z, y, x = zyx(one[:3, :3])
        place = ",".join([*(f"{v:.3f}" for v in one[:3, 3]), *(f"{v:.4f}" for v in (x, y, z))])
        lines += [f"///RCONF 1,0,0,{beyond[k][0]},{beyond[k][1]},{beyond[k][2]}", f"C{k:05d}={place}"]
    moves = [f"MOVJ C{k:05d} VJ=10.00" for k in range(len(joints))]
    return "\n".join([*lines, "//INST", "///DATE 2026/01/01 10:00", "NOP", *moves, "END", ""]).encode()


def taken_by_yaskawa(robot, data, drawn):
    read = _read(rb"RCONF 1,0,0,([0-9],[0-9],[0-9])\nC[0-9]+=(.*)", data)
    pose = _pose(read[:, 3:6], from_zyx(read[:, [8, 7, 6]]))
    taken = _within_limits(robot, _of_bits(robot, pose, other.posture(robot, drawn)))
    beyond = np.abs(taken[:, [3, 5, 0]]) > np.pi
    wrong = (beyond != read[:, :3].astype(bool)).any(axis=1)
    return np.where(wrong[:, None], np.nan, taken)


def gcode(robot, joints):
    lines = ["G21 G90 G54 T1"]
    for one in other.transform(robot, joints):
        words = zip("XYZABC", [*one[:3, 3], *zyx(one[:3, :3])], strict=True)
        lines.append("G0 " + " ".join(f"{letter}{value:.9f}" for letter, value in words))
    return "\n".join([*lines, ""]).encode()


def taken_by_machine(robot, data, drawn):
    read = _read(rb"X(\S+) Y(\S+) Z(\S+) A(\S+) B(\S+) C(\S+)", data)
    pose = _pose(read[:, :3], from_zyx(read[:, 3:]))
    return _within_limits(robot, _of_bits(robot, pose, other.posture(robot, drawn)))


# Universal Robots, lists -----------------------------------------------------------------------------------
def script(robot, joints):
    lines, moves = ["def m():", "  set_tcp(p[0,0,0,0,0,0])"], []
    for k, one in enumerate(other.transform(robot, joints)):
        near = ",".join(f"{v:.12f}" for v in joints[k])
        lines += [f"  p{k}=p[{_script_pose(one)}]", f"  n{k}=[{near}]"]
        moves.append(f"  movej(get_inverse_kin(p{k}, qnear=n{k}), a=1, v=1)")
    return "\n".join([*lines, *moves, "end", ""]).encode()


def script_of_moves(robot, joints):
    """Each pose is reached from joints some degrees away, which are corrected themselves."""
    away = np.random.default_rng(len(joints)).uniform(-_AWAY, _AWAY, joints.shape)
    lines = ["def m():", "  set_tcp(p[0,0,0,0,0,0])"]
    for k, one in enumerate(other.transform(robot, joints)):
        before = ",".join(f"{v:.12f}" for v in joints[k] + away[k])
        lines += [f"  n{k}=[{before}]", f"  p{k}=p[{_script_pose(one)}]"]
    moves = [f"  movej(n{k})\n  movej(p{k})" for k in range(len(joints))]
    return "\n".join([*lines, *moves, "end", ""]).encode()


def _script_pose(one):
    return ",".join(f"{v:.12f}" for v in [*one[:3, 3] / 1000, *vector(one[:3, :3])])


def taken_by_ur(robot, data, drawn):
    read, near = _read(rb" p[0-9]+=p\[(.*?)()\]", data), _read(rb" n[0-9]+=\[(.*?)()\]", data)
    return _nearest(robot, _pose(1000 * read[:, :3], from_vector(read[:, 3:])), near)


def _nearest(robot, pose, near):
    taken = []
    for first in range(0, len(pose), 200):
        part = slice(first, first + 200)
        every = other.turned_to(other.searched_answers(robot, pose[part], near[part]), near[part, None])
        apart = np.nan_to_num(((every - near[part, None]) ** 2).sum(axis=2), nan=np.inf)
        taken.append(every[np.arange(len(every)), apart.argmin(axis=1)])
    return np.concatenate(taken)


def listed(robot, joints):
    rows = []
    for k, one in enumerate(other.transform(robot, joints)):
        values = [*one[:3, 3], *quaternion(one[:3, :3]), *np.degrees(joints[k])]
        keys = ["x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz", *(f"q{j}_deg" for j in range(1, 7))]
        rows.append({"target": f"p{k}", **dict(zip(keys, map(float, values), strict=True))})
    return json.dumps({"targets": rows}, indent=1).encode()


def taken_of_list(robot, data, drawn):
    rows = [[value for key, value in row.items() if key != "target"] for row in json.loads(data)["targets"]]
    read = np.array(rows)
    return _nearest(robot, _pose(read[:, :3], from_quaternion(read[:, 3:7])), np.radians(read[:, 7:]))
