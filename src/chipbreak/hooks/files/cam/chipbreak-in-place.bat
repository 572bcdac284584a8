@echo off
rem A CAM system runs this with the name of the program that it has just posted as the last argument.
rem A rejected program is taken away from its place, so that nobody runs it: NAME.rejected says why, NAME.unfiltered is it.
if "%CHIPBREAK_PROFILE%"=="" set "CHIPBREAK_PROFILE=@PROFILE@"
set "program="
for %%a in (%*) do (
    set "program=%%~fa"
    set "folder=%%~dpa"
)
if "%program%"=="" exit /b 2
"@CHIPBREAK@" filter -i --fresh --backup .unfiltered --reject-file --log "%folder%chipbreak.log" "%program%"
set code=%errorlevel%
if not "%code%"=="0" move /y "%program%" "%program%.unfiltered" >nul
exit /b %code%
