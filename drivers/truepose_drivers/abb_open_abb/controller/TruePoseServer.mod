MODULE TruePoseServer
    !*****************************************************************************************
    ! Joint-target server for truepose: the subset of the open_abb text protocol that a
    ! calibration session needs (codes 0, 2, 4, 6, 7, 8, 9, 98, 99), with joint angles reported
    ! to five decimals instead of two, and three codes of its own:
    !   94            the speed that holds: "94 1 v_tcp v_ori"
    !   95 seconds    watch this client: a motion is stopped and given up when nothing was heard
    !                 of it for so long; 0: never. Asked for anew by each client.
    !   96            the client is there; has no reply, and may stand before another request
    ! Whoever does not send 95 is served as by the public server.
    !
    ! NEVER TRIED ON HARDWARE, nor in a virtual controller. Read it, load it in manual reduced
    ! speed, and keep a hand on the enabling device when it runs for the first time.
    !
    ! Needs RobotWare with the option "PC Interface". One client at a time on port 5000.
    ! Every motion ends in a fine point: the reply to code 2 says that the arm is at rest.
    ! A motion that the controller cannot make stops this program; nothing is replied then.
    ! A motion that was given up has no reply either: the client's connection is closed, and the
    ! next client finds the arm at rest where it stopped.
    !
    ! The watch is a timer interrupt of this task: while MoveAbsJ waits for the end of the motion,
    ! the trap looks for beats on the client's socket. This is no safety function.
    !*****************************************************************************************

    CONST num SERVER_PORT:=5000;
    CONST num MOST_VALUES:=10;
    CONST num STATUS_BAD:=0;
    CONST num STATUS_OK:=1;
    CONST num ANGLE_DECIMALS:=5;
    CONST num SPEED_DECIMALS:=2;
    CONST num LOOK_S:=0.1;
    CONST num FOR_EVER:=0;
    CONST string SERVER_NAME:="truepose 3";
    CONST string BEAT:="96 #";

    PERS string serverAddress:="192.168.125.1";
    PERS tooldata sessionTool:=[TRUE,[[0,0,0],[1,0,0,0]],[0.001,[0,0,0.001],[1,0,0,0],0,0,0]];

    VAR socketdev listener;
    VAR socketdev client;
    VAR speeddata sessionSpeed:=[100,20,0,0];
    VAR num values{10};
    VAR num valueCount;
    VAR num code;
    VAR bool leaving;
    VAR num watchedFor:=FOR_EVER;
    VAR clock sinceHeard;
    VAR intnum lookInterrupt;
    VAR bool clientGone:=FALSE;
    VAR bool givenUp:=FALSE;

    PROC main()
        StreamJoints;
        CONNECT lookInterrupt WITH LookForClient;
        ITimer LOOK_S,lookInterrupt;
        ISleep lookInterrupt;
        OpenServer;
        WHILE TRUE DO
            ServeOneRequest;
        ENDWHILE
    ENDPROC

    ! Streams the joints by EGM where TruePoseEgm is loaded.
    PROC StreamJoints()
        %"StartEgm"%;
    ERROR
        IF ERRNO=ERR_REFUNKPRC TRYNEXT;
        RAISE;
    ENDPROC

    PROC ServeOneRequest()
        VAR string request;
        VAR string reply;

        SocketReceive client\Str:=request\Time:=WAIT_MAX;
        request:=WithoutBeats(request);
        IF request="" RETURN;
        IF NOT IsParsed(request) THEN
            reply:=Head(STATUS_BAD);
        ELSEIF code=2 AND valueCount=6 THEN
            ! A motion stands in a routine of its own: only there can it be given up.
            MoveWatched;
            reply:=Head(STATUS_OK);
        ELSE
            reply:=Carried();
        ENDIF
        IF leaving OR givenUp THEN
            leaving:=FALSE;
            givenUp:=FALSE;
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

    ! Moves; comes back with givenUp set where the client fell silent on the way.
    PROC MoveWatched()
        clientGone:=FALSE;
        ClkStop sinceHeard;
        ClkReset sinceHeard;
        ClkStart sinceHeard;
        IF watchedFor>FOR_EVER IWatch lookInterrupt;
        MoveAbsJ Target(),sessionSpeed,fine,sessionTool;
        ISleep lookInterrupt;
    ERROR
        IF ERRNO=ERR_PATH_STOP THEN
            ! The trap has stopped the arm. What is left of the path is thrown away, so that no
            ! later start of motion goes on with it.
            ISleep lookInterrupt;
            ClearPath;
            StartMove;
            givenUp:=TRUE;
            RETURN;
        ENDIF
        RAISE;
    ENDPROC

    TRAP LookForClient
        VAR string heard;

        IF SocketPeek(client)>0 THEN
            SocketReceive client\Str:=heard\Time:=LOOK_S;
            ClkReset sinceHeard;
            ClkStart sinceHeard;
        ELSEIF SocketGetStatus(client)<>SOCKET_CONNECTED THEN
            clientGone:=TRUE;
        ENDIF
        IF clientGone OR ClkRead(sinceHeard)>watchedFor THEN
            ISleep lookInterrupt;
            ! Stops the arm on its path and raises ERR_PATH_STOP in the routine that moves.
            StopMove\Quick;
            ProcerrRecovery\SyncLastMoveInst;
        ENDIF
    ERROR
        ! The socket died under us: whoever was there is gone.
        clientGone:=TRUE;
        TRYNEXT;
    ENDTRAP

    ! Beats that came before the end of a motion was known to the client.
    FUNC string WithoutBeats(string request)
        VAR num length;

        length:=StrLen(BEAT);
        WHILE StrLen(request)>=length DO
            IF StrPart(request,1,length)<>BEAT RETURN request;
            IF StrLen(request)=length RETURN "";
            request:=StrPart(request,length+1,StrLen(request)-length);
        ENDWHILE
        RETURN request;
    ENDFUNC

    FUNC string Carried()
        TEST code
        CASE 0:
            IF valueCount=0 RETURN Head(STATUS_OK);
        CASE 4:
            IF valueCount=0 RETURN Head(STATUS_OK)+JointText(CJointT());
        CASE 6:
            ! The point at which the speed holds.
            IF valueCount=7 THEN
                sessionTool.tframe.trans:=[values{1},values{2},values{3}];
                sessionTool.tframe.rot:=[values{4},values{5},values{6},values{7}];
                RETURN Head(STATUS_OK);
            ENDIF
        CASE 7:
            ! Joint targets know no work object: it is accepted and ignored.
            IF valueCount=7 RETURN Head(STATUS_OK);
        CASE 8:
            IF valueCount=2 OR valueCount=4 THEN
                sessionSpeed.v_tcp:=values{1};
                sessionSpeed.v_ori:=values{2};
                RETURN Head(STATUS_OK);
            ENDIF
        CASE 9:
            ! Zones are accepted and ignored: a session measures at rest, so every point is fine.
            IF valueCount=4 RETURN Head(STATUS_OK);
        CASE 94:
            IF valueCount=0 RETURN Head(STATUS_OK)+NumToStr(sessionSpeed.v_tcp,SPEED_DECIMALS)+" "+NumToStr(sessionSpeed.v_ori,SPEED_DECIMALS);
        CASE 95:
            IF valueCount=1 AND values{1}>=FOR_EVER THEN
                watchedFor:=values{1};
                RETURN Head(STATUS_OK);
            ENDIF
        CASE 98:
            IF valueCount=0 RETURN Head(STATUS_OK)+GetSysInfo(\SerialNo)+"*"+GetSysInfo(\SWVersion)+"*"+GetSysInfo(\RobotType)+"*"+SERVER_NAME;
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
        ! The next client says itself whether it wants to be watched.
        watchedFor:=FOR_EVER;
    ENDPROC

    PROC ReopenServer()
        SocketClose client;
        SocketClose listener;
        WaitTime 0.5;
        OpenServer;
    ENDPROC
ENDMODULE
