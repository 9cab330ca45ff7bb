MODULE TruePoseEgm
    !*****************************************************************************************
    ! Streams where the joints are to truepose, while another program moves the arm. Load it
    ! beside TruePoseServer or TruePoseRws, whose main calls StartEgm where it finds it; from a
    ! program of your own call it before the first motion.
    !
    ! NEVER TRIED ON HARDWARE, nor in a virtual controller.
    !
    ! Needs the RobotWare option "Externally Guided Motion", and a transmission protocol of type
    ! UDPUC with the name below, whose remote address is the computer with truepose and whose
    ! remote port is the egm_port of its cell file. The computer guides nothing: this stream is
    ! one of positions only.
    !*****************************************************************************************

    CONST string UDP_DEVICE:="TruePosePc";
    CONST num EVERY_MS:=4;

    VAR egmident streamId;

    PROC StartEgm()
        EGMReset streamId;
        EGMGetId streamId;
        EGMSetupUC ROB_1,streamId,"default",UDP_DEVICE\Joint;
        EGMStreamStart streamId\SampleRate:=EVERY_MS;
    ENDPROC
ENDMODULE
