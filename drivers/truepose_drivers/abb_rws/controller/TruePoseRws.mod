MODULE TruePoseRws
    !*****************************************************************************************
    ! Moves the arm for truepose over Robot Web Services 1.0: no sockets, no further option.
    ! A client writes an order, reads from the report what was understood, and gives beats:
    !   tpOrder   number, six joint angles [deg], speed of the tool [mm/s], its turning [deg/s]
    !   tpBeat    any number; each change says that the client is there
    !   tpReport  0 waiting, 1 taken, 2 moving, 3 arrived, 4 given up, 5 refused; then the order
    !
    ! An order that stands there when the program starts counts for nothing. One that was taken
    ! moves nothing before the first beat, and the arm is stopped and the rest of the path thrown
    ! away when no beat has come for 0.8 s. Every motion ends in a fine point.
    !
    ! NEVER TRIED ON HARDWARE, nor in a virtual controller. Read it, load it into T_ROB1 as the
    ! only module with a main, in manual reduced speed, and keep a hand on the enabling device
    ! when it runs for the first time.
    !
    ! The watch is a timer interrupt of this task, as in TruePoseServer. It is no safety function.
    !*****************************************************************************************

    CONST num WAITING:=0;
    CONST num TAKEN:=1;
    CONST num MOVING:=2;
    CONST num ARRIVED:=3;
    CONST num GIVEN_UP:=4;
    CONST num REFUSED:=5;
    CONST num SILENCE_S:=0.8;
    CONST num LOOK_S:=0.1;
    ! For the first beat of an order, before which nothing moves.
    CONST num PATIENCE_S:=3;

    PERS string tpServer:="truepose rws 1";
    PERS num tpOrder{9}:=[0,0,0,0,0,0,0,0,0];
    PERS num tpBeat:=0;
    PERS num tpReport{10}:=[0,0,0,0,0,0,0,0,0,0];
    ! Speeds hold at its point: set it to the farthest nest.
    PERS tooldata sessionTool:=[TRUE,[[0,0,0],[1,0,0,0]],[0.001,[0,0,0.001],[1,0,0,0],0,0,0]];

    VAR num order{9};
    VAR num lastBeat;
    VAR clock sinceHeard;
    VAR intnum lookInterrupt;

    PROC main()
        StreamJoints;
        IDelete lookInterrupt;
        CONNECT lookInterrupt WITH LookForBeat;
        ITimer LOOK_S,lookInterrupt;
        ISleep lookInterrupt;
        order:=tpOrder;
        Tell WAITING;
        WHILE TRUE DO
            WaitUntil tpOrder{1}<>order{1}\PollRate:=0.02;
            order:=tpOrder;
            CarryOut;
        ENDWHILE
    ENDPROC

    ! Streams the joints by EGM where TruePoseEgm is loaded.
    PROC StreamJoints()
        %"StartEgm"%;
    ERROR
        IF ERRNO=ERR_REFUNKPRC TRYNEXT;
        RAISE;
    ENDPROC

    PROC CarryOut()
        VAR bool silent;

        IF order{8}<=0 OR order{9}<=0 THEN
            Tell REFUSED;
            RETURN;
        ENDIF
        lastBeat:=tpBeat;
        Tell TAKEN;
        WaitUntil tpBeat<>lastBeat\MaxTime:=PATIENCE_S\TimeFlag:=silent\PollRate:=0.02;
        IF silent THEN
            Tell GIVEN_UP;
            RETURN;
        ENDIF
        ! A motion stands in a routine of its own: only there can it be given up.
        MoveWatched;
    ENDPROC

    PROC MoveWatched()
        HearBeat;
        Tell MOVING;
        IWatch lookInterrupt;
        MoveAbsJ Target(),[order{8},order{9},0,0],fine,sessionTool;
        ISleep lookInterrupt;
        Tell ARRIVED;
    ERROR
        IF ERRNO=ERR_PATH_STOP THEN
            ! The trap has stopped the arm. What is left of the path is thrown away, so that no
            ! later start of motion goes on with it.
            ISleep lookInterrupt;
            ClearPath;
            StartMove;
            Tell GIVEN_UP;
            RETURN;
        ENDIF
        RAISE;
    ENDPROC

    TRAP LookForBeat
        IF tpBeat<>lastBeat THEN
            HearBeat;
        ELSEIF ClkRead(sinceHeard)>SILENCE_S THEN
            ISleep lookInterrupt;
            ! Stops the arm on its path and raises ERR_PATH_STOP in the routine that moves.
            StopMove\Quick;
            ProcerrRecovery\SyncLastMoveInst;
        ENDIF
    ENDTRAP

    PROC HearBeat()
        lastBeat:=tpBeat;
        ClkStop sinceHeard;
        ClkReset sinceHeard;
        ClkStart sinceHeard;
    ENDPROC

    FUNC jointtarget Target()
        VAR jointtarget goal;

        ! External axes, where there are any, keep their place.
        goal:=CJointT();
        goal.robax:=[order{2},order{3},order{4},order{5},order{6},order{7}];
        RETURN goal;
    ENDFUNC

    ! In one assignment: whoever reads meanwhile sees the report before or the one after.
    PROC Tell(num progress)
        tpReport:=[progress,order{1},order{2},order{3},order{4},order{5},order{6},order{7},order{8},order{9}];
    ENDPROC
ENDMODULE
