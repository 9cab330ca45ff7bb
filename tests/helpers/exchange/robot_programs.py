"""Robot programs as shops have them: written by hand for the tests, one a format."""

import re

from truepose.exchange.programs.formats import read_program
from truepose.messages.catalogue import english

RAPID = r"""%%%
  VERSION:1
  LANGUAGE:ENGLISH
%%%
MODULE Palette(SYSMODULE)
  ! Tür 3: [taught] in week 12; was MoveL p99,v100,fine,tool0;
  CONST robtarget pPick:=[[600,500,225.3],[0.7071,0,0.7071,0],[1,-1,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PERS tooldata tGrip:=[TRUE,[[97.4,0,223.1],[0.924,0,0.383,0]],[5,[23,0,75],[1,0,0,0],0,0,0]];
  TASK PERS wobjdata wTable:=[FALSE,TRUE,"",[[300,600,200],[1,0,0,0]],[[0,200,30],[1,0,0,0]]];
  LOCAL VAR robtarget pRow{2}:=[
     [[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],  ! the first
     [[-4.5,  5 ,6e1],[1,0,0,0],[0,0,0,0],[12.5,9E9,9E9,9E9,9E9,9E9]] ];
  CONST jointtarget jHome:=[[0,-30,30,0,90,1E-05],[9E9,9E9,9E9,9E9,9E9,9E9]];
  VAR robtarget pNow;
  VAR robtarget pShift:=[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    VAR num i;
    TPWrite "MoveL pPick, [[1,2";
    MoveAbsJ jHome\NoEOffs,v1000,fine,tGrip\WObj:=wTable;
    MoveJ Offs(pPick,0,0,100),v1000,z10,tGrip\WObj:=wTable;
    movel pPick,v100\V:=50,fine,tGrip\WObj:=wTable;
    SetDO doGrip,1;
    MoveL \Conc, [[7,8,9],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tGrip\WObj:=wTable;
    FOR i FROM 1 TO 2 DO
      MoveL pRow{i},v100,fine,tool0;
    ENDFOR
    MoveL pRow{1},v100,fine,tool0;
    MoveL pRow{2},v100,fine,tool0;
    pNow:=CRobT();
    MoveL pNow,v100,fine,tool0;
    pShift.trans.z:=pShift.trans.z+10;
    MoveL pShift,v100,fine,tool0;
    MoveC pPick,pRow{2},v100,fine,tool0;
    IF di1=1 MoveL *,v100,fine,tool0;
    place pPick;
  ENDPROC
  PROC place(robtarget pWhere)
    MoveL pWhere,v100,fine,tool0;
    MoveL pElsewhere,v100,fine,tool0;
  ENDPROC
ENDMODULE
""".replace("\n", "\r\n").encode("latin-1")

KRL = b"""&ACCESS RVP
&REL 1
DEF ROW( )
;FOLD INI;%{PE}
DECL E6POS HERE
E6POS PTS[3]
FRAME OFFS
DECL E6AXIS HOME={A1 0.0,A2 -90.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0,E1 12.0}
BAS (#INITMOV,0 )
$TOOL=TOOL_DATA[1]
$BASE={X 1000,Y 0,Z 500,A 90,B 0,C 0} ; the table {
PTS[1]={X 100.0,Y -5.5,Z 1E2,A 10.0,B 89.5,C -170.0,S 'B110',T 'B010011'}
PTS[2]={E6POS: X 110.0,Y -5.5,Z 100.0,A 10.0,B 20.0,C -170.0,S 6,T 19,E1 100.0}
OFFS={X 0.0,Y 0.0,Z 50.0,A 0.0,B 0.0,C 0.0}
PTP HOME
PTP XP1 C_PTP
LIN PTS[1] C_DIS
LIN PTS[2]:OFFS
LIN PTS[2]
FOR I=1 TO 2
LIN PTS[I]
ENDFOR
LIN {X 100}
LIN_REL {Z 100}
PTP {A1 10.0,A2 -90.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0}
CIRC PTS[1],PTS[2]
LIN {POS: X 1.0,Y 2.0,Z 3.0,A 0.0,B 0.0,C 0.0} C_DIS
HERE=$POS_ACT
LIN HERE
MOVEIT(PTS[1])
END
"""

KRL_DATA = b"""DEFDAT ROW PUBLIC
EXT BAS (BAS_COMMAND :IN,REAL :IN )
DECL E6POS XP1={X 214.483856,Y 193.590897,Z 1005.80865,A 6.59456158,B -23.4313526,C 9.77940178,S 2,T 3}
DECL FDAT FP1={TOOL_NO 2,BASE_NO 0,IPO_FRAME #BASE,POINT2[] " ",TQ_STATE FALSE}
DECL E6POS XP2={X 214.0,Y 193.0,Z 1005.0,A 6.5,B -23.4,C 9.7,S 2,T 3}
DECL FDAT FP2={TOOL_NO 2,BASE_NO 1,IPO_FRAME #TCP,POINT2[] " {X 1",TQ_STATE FALSE}
TOOL_DATA[2]={X 0.0,Y 0.0,Z 200.0,A 0.0,B 90.0,C 0.0}
DECL PDAT PPDAT1={VEL 100.000,ACC 100.000}
ENDDAT
"""

FANUC = """/PROG  ROW
/ATTR
OWNER\t\t= MNEDITOR;
COMMENT\t\t= "P[1]{ X = 5 mm";
/MN
   1:  UFRAME_NUM=1 ;
   2:  !go to P[9] ;
   3:J P[1] 100% FINE    ;
   4:L P[2:approach] 500mm/sec CNT50 Offset,PR[1]    ;
   5:L P[2:approach] 500mm/sec FINE    ;
   6:L P[6] 500mm/sec FINE    ;
   7:C P[3]
    :  P[4] 200mm/sec FINE    ;
   8:L PR[1] 100mm/sec FINE ;
   9:L P[R[1]] 100mm/sec FINE ;
  10:L P[8] 100mm/sec FINE ;
  11:J P[2] 10% FINE INC ;
  12:  IF R[1]=1,JMP LBL[1] ;
  13:L P[6] 100mm/sec FINE ;
  14:  P[7]=LPOS ;
/POS
P[1:"Höhe"]{
   GP1:
\tUF : 0, UT : 1,\t
\tJ1=    25.000 deg,\tJ2=   -50.000 deg,\tJ3=    60.000 deg,
\tJ4=   -35.000 deg,\tJ5=     -.045 deg,\tJ6=    50.000 deg,
\tE1=   100.000  mm
   GP2:
\tUF : 0, UT : 1,\t
\tJ1=     0.000  mm
};
P[2:"approach"]{
   GP1:
\tUF : 1, UT : 2,\t\tCONFIG : 'N U T, 0, 0, 0',
\tX = -1371.166  mm,\tY =  2539.539  mm,\tZ =  -538.770  mm,
\tW =  -175.187 deg,\tP =   -34.176 deg,\tR =     8.232 deg
};
P[3]{
   GP1:
\tUF : 1, UT : 2,\t\tCONFIG : 'N U T, 0, 0, 0',
\tX =  -371.166  mm,\tY =  2539.539  mm,\tZ =  -538.770  mm,
\tW =  -175.187 deg,\tP =   -34.176 deg,\tR =     8.232 deg
};
P[5]{
   GP1:
\tUF : 1, UT : 2,\t\tCONFIG : 'N U T, 0, 0, 0',
\tX = ********  mm,\tY = ********  mm,\tZ = ********  mm,
\tW = ******** deg,\tP = ******** deg,\tR = ******** deg
};
P[6]{
   GP1:
\tUF : 0, UT : 2,\t\tCONFIG : 'F D T, 0, 0, 1',
\tX =   371.166  mm,\tY =   539.539  mm,\tZ =   538.770  mm,
\tW =    10.000 deg,\tP =    20.000 deg,\tR =    30.000 deg
};
P[7]{
   GP1:
\tUF : 0, UT : 2,\t\tCONFIG : 'F D T, 0, 0, 1',
\tX =   371.166  mm,\tY =   539.539  mm,\tZ =   538.770  mm,
\tW =    10.000 deg,\tP =    20.000 deg,\tR =    30.000 deg
};
/END
""".replace("\n", "\r\n").encode("latin-1")

UR = b"""def row():
  # was movej([1,2,3
  set_tcp(p[0.0,0.0,.125,0.0,0.0,0.0])
  global Waypoint_1_p=p[.433025361705, -.467959205379, .522310714714, 1.500318891221, .521427297251, .530987]
  global Waypoint_1_q=[1.9942498207092285, -1.66846146206, 1.93305045763, -0.271842316, 1.32090044, 0.0036344]
  pts=[p[.1,.2,.3,0,3.14159,0],p[.1,.2,.4,2.2,2.2,0]]
  axes=[0,0,9.82,1,2,3]
  $ 1 "Robot Program [("
  movej(get_inverse_kin(Waypoint_1_p, qnear=Waypoint_1_q), a=1.3962634015954636, v=1.0471975511965976)
  movel(pts[0], a=1.2,
     v=0.1)
  movel(pose_trans(pts[0], p[0,0,.1,0,0,0]))
  i = 0
  while i < 2:
    movel(pts[i])
    i = i+1
  end
  movej([0,-1.57, 1.57,0,0,d2r(5)])
  movej(q=[0,-1.57, 1.57,0,0,1.0e-1])
  movec(pts[0],pts[1])
  movel(other)
  servoj([0,-1.57, 1.57,0,0,0], 0, 0, 0.008)
  grip(pts)
end
"""

JSON = b"""{"targets": [
 {"target": "p1 {[", "x_mm": 100.5, "y_mm": 2e2, "z_mm": -3, "qw": 1, "qx": 0, "qy": 0, "qz": 0,
  "note": "12, \\"x_mm\\": 5"},
 {"x_mm": 100.5, "y_mm": 2e2, "z_mm": -3, "qw": 1, "qx": 0, "qy": 0, "qz": 0, "nest": 2, "list": [1, [2, 3]]}
], "x_mm": 2}
"""

GCODE = b"""%
N10 G90 G21 (to X1)
N20 G0 X10 Y20.5 Z30 A0 B90 C-10.25 F1000 ; X9
N30 G01X11.Y21.Z31.A1B89C0
N40 X12
N50 G2 X13 Y3 I2
N60 G54
N70 G1 X1 Y1 Z1 A0 B0 C0
N80 G91
N90 G1 X1 Y1 Z1 A0 B0 C0
G28 X0
M30
"""

INFORM = b"""/JOB
//NAME ROW
//POS
///NPOS 3,0,0,1,0,0
///TOOL 1
///POSTYPE PULSE
///PULSE
C00000=-1,-114489,-86932,1,-5369,-1
EC00000=12,0
///USER 2
///POSTYPE USER
///RECTAN
///RCONF 1,0,0,0,0,0,0,0
C00001=1057.372,-422.436,620.000,-179.9371,0.0009,-0.0221
C00002=1057.372,-422.436,620.000,-179.94,0.00,-0.02
P00003=1057.372,-422.436,620.000,-179.9371,0.0009,-0.0221
///POSTYPE ANGLE
///ANGLE
C00004=10.0000,20.0000,30.0000,40.0000,50.0000,60.0000
//INST
///DATE 2020/01/01 10:00
///ATTR SC,RW,RJ
////FRAME USER 2
///GROUP1 RB1
NOP
'MOVL C00001
MOVJ C00000 VJ=50.00
MOVL C00001 V=100.0
MOVL P003 V=100.0
MOVJ C00004 VJ=1.00
SFTON P000 UF#(1)
MOVL C00002 V=100.0
SFTOF
MOVL P[I000] V=1.0
IMOV P003 V=1
JUMP *A
MOVC C00002 V=2
END
""".replace(b"\n", b"\r\n")

VAL3 = b"""<?xml version="1.0" encoding="utf-8" ?>
<Database xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xmlns="http://www.staubli.com/robotics/VAL3/Data/2">
  <Datas>
    <!-- <Value key="9" x="1"/> -->
    <Data name="fPart" access="public" xsi:type="array" type="frame" size="1">
      <Value key="0" x="100" z="5" rz="90" fatherId="world[0]" />
    </Data>
    <Data name="jHome" access="private" xsi:type="array" type="joint" size="1">
      <Value key="0" j1="0.0" j2="10" j3="90.5" j4="0" j5="-1e1" j6="0" />
    </Data>
    <Data name="pPick" access="private" xsi:type="array" type="pointRx" size="2">
      <Value key="0" x="-36.802" y="-6.159" z='500.000' rx="135.407" ry="80.416" rz="46.453" shoulder="lefty"
             elbow="epositive" wrist="wpositive" fatherId="fPart[0]" />
      <Value key="1" x="5" fatherId="fElse[0]" />
    </Data>
  </Datas>
</Database>
"""

PROGRAMS = {
    "row.mod": RAPID,
    "row.src": KRL,
    "row.dat": KRL_DATA,
    "row.ls": FANUC,
    "row.script": UR,
    "row.json": JSON,
    "row.nc": GCODE,
    "row.jbi": INFORM,
    "row.dtx": VAL3,
}


def read(name, data=None):
    """Return a program; G-code is told what its angles turn about."""
    return read_program(PROGRAMS[name] if data is None else data, name, angles="zyx")


def named(program, name):
    """Return the one target of that name."""
    (found,) = [target for target in program.targets if target.name == name]
    return found


def reasons(program):
    """Return why something is left alone, by line."""
    return {entry.line: english(entry.reason) for entry in program.left_alone}


def line_of(data, text):
    """Return the 1-based line of the only place where a text stands."""
    assert data.count(text) == 1
    return data.count(b"\n", 0, data.index(text)) + 1


def without_numbers(program):
    """Return the file with a mark for every number of a target."""
    places = [(n.start, n.end) for t in program.targets for written in t.written for n in written.numbers]
    data = program.data
    for start, end in sorted(places, reverse=True):
        assert re.fullmatch(rb"[-+]?\s*[0-9.]+(?:[eE][-+]?[0-9]+)?", data[start:end])
        data = data[:start] + b"#" + data[end:]
    return data
