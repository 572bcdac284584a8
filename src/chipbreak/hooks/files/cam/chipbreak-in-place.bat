@echo off
rem A CAM system runs this with the name of the program that it has just posted.
rem A rejected program is taken away from its place, so that nobody runs it: NAME.rejected says why, NAME.unfiltered is it.
if "%CHIPBREAK_PROFILE%"=="" set CHIPBREAK_PROFILE=@PROFILE@
"@CHIPBREAK@" filter -i --fresh --backup .unfiltered --reject-file --log "%~dp1chipbreak.log" "%~1"
set code=%errorlevel%
if not "%code%"=="0" move /y "%~1" "%~1.unfiltered" >nul
exit /b %code%
