MODULE TruePoseServer
    !*****************************************************************************************
    ! Joint-target server for truepose: the subset of the open_abb text protocol that a
    ! calibration session needs (codes 0, 2, 4, 8, 9, 98, 99), with joint angles reported to
    ! five decimals instead of two.
    !
    ! NEVER TRIED ON HARDWARE, nor in a virtual controller. Read it, load it in manual reduced
    ! speed, and keep a hand on the enabling device when it runs for the first time.
    !
    ! Needs RobotWare with the option "PC Interface". One client at a time on port 5000.
    ! Every motion ends in a fine point: the reply to code 2 says that the arm is at rest.
    ! A motion that the controller cannot make stops this program; nothing is replied then.
    !*****************************************************************************************

    CONST num SERVER_PORT:=5000;
    CONST num MOST_VALUES:=10;
    CONST num STATUS_BAD:=0;
    CONST num STATUS_OK:=1;
    CONST num ANGLE_DECIMALS:=5;

    PERS string serverAddress:="192.168.125.1";
    PERS tooldata sessionTool:=[TRUE,[[0,0,0],[1,0,0,0]],[0.001,[0,0,0.001],[1,0,0,0],0,0,0]];

    VAR socketdev listener;
    VAR socketdev client;
    VAR speeddata sessionSpeed:=[100,20,0,0];
    VAR num values{10};
    VAR num valueCount;
    VAR num code;
    VAR bool leaving;

    PROC main()
        OpenServer;
        WHILE TRUE DO
            ServeOneRequest;
        ENDWHILE
    ENDPROC

    PROC ServeOneRequest()
        VAR string request;
        VAR string reply;

        SocketReceive client\Str:=request\Time:=WAIT_MAX;
        IF NOT IsParsed(request) THEN
            reply:=Head(STATUS_BAD);
        ELSE
            reply:=Carried();
        ENDIF
        IF leaving THEN
            leaving:=FALSE;
            ReopenServer;
        ELSE
            SocketSend client\Str:=reply;
        ENDIF
    ERROR
        IF ERRNO=ERR_SOCK_CLOSED THEN
            ! The request is lost with its client: the next one begins afresh.
            ReopenServer;
            RETURN;
        ENDIF
        RAISE;
    ENDPROC

    FUNC string Carried()
        TEST code
        CASE 0:
            IF valueCount=0 RETURN Head(STATUS_OK);
        CASE 2:
            IF valueCount=6 THEN
                MoveAbsJ Target(),sessionSpeed,fine,sessionTool;
                RETURN Head(STATUS_OK);
            ENDIF
        CASE 4:
            IF valueCount=0 RETURN Head(STATUS_OK)+JointText(CJointT());
        CASE 8:
            IF valueCount=2 OR valueCount=4 THEN
                sessionSpeed.v_tcp:=values{1};
                sessionSpeed.v_ori:=values{2};
                RETURN Head(STATUS_OK);
            ENDIF
        CASE 9:
            ! Zones are accepted and ignored: a session measures at rest, so every point is fine.
            IF valueCount=4 RETURN Head(STATUS_OK);
        CASE 98:
            IF valueCount=0 RETURN Head(STATUS_OK)+GetSysInfo(\SerialNo)+"*"+GetSysInfo(\SWVersion)+"*"+GetSysInfo(\RobotType);
        CASE 99:
            leaving:=TRUE;
            RETURN "";
        ENDTEST
        RETURN Head(STATUS_BAD);
    ENDFUNC

    ! "code status " in front of every reply; the space stays when no text follows.
    FUNC string Head(num status)
        RETURN NumToStr(code,0)+" "+NumToStr(status,0)+" ";
    ENDFUNC

    FUNC jointtarget Target()
        VAR jointtarget goal;

        ! External axes, where there are any, keep their place.
        goal:=CJointT();
        goal.robax:=[values{1},values{2},values{3},values{4},values{5},values{6}];
        RETURN goal;
    ENDFUNC

    FUNC string JointText(jointtarget joints)
        VAR string text;

        text:=NumToStr(joints.robax.rax_1,ANGLE_DECIMALS)+" "+NumToStr(joints.robax.rax_2,ANGLE_DECIMALS);
        text:=text+" "+NumToStr(joints.robax.rax_3,ANGLE_DECIMALS)+" "+NumToStr(joints.robax.rax_4,ANGLE_DECIMALS);
        RETURN text+" "+NumToStr(joints.robax.rax_5,ANGLE_DECIMALS)+" "+NumToStr(joints.robax.rax_6,ANGLE_DECIMALS);
    ENDFUNC

    ! Splits "code value value ... #" at its spaces; false when the end mark or a number is missing.
    FUNC bool IsParsed(string request)
        VAR num start:=1;
        VAR num stop;
        VAR num number;
        VAR bool hasCode:=FALSE;

        code:=255;
        valueCount:=0;
        WHILE start<=StrLen(request) DO
            stop:=StrFind(request,start," ");
            IF stop>start THEN
                IF StrPart(request,start,stop-start)="#" RETURN hasCode;
                IF NOT StrToVal(StrPart(request,start,stop-start),number) RETURN FALSE;
                IF NOT hasCode THEN
                    code:=number;
                    hasCode:=TRUE;
                ELSEIF valueCount<MOST_VALUES THEN
                    Incr valueCount;
                    values{valueCount}:=number;
                ELSE
                    RETURN FALSE;
                ENDIF
            ENDIF
            start:=stop+1;
        ENDWHILE
        RETURN FALSE;
    ENDFUNC

    PROC OpenServer()
        SocketCreate listener;
        SocketBind listener,serverAddress,SERVER_PORT;
        SocketListen listener;
        SocketAccept listener,client\Time:=WAIT_MAX;
    ENDPROC

    PROC ReopenServer()
        SocketClose client;
        SocketClose listener;
        WaitTime 0.5;
        OpenServer;
    ENDPROC
ENDMODULE
