# Writes to OUTPUT what LIBRARY refers to of GDAL, for late_gdal.cpp. NM: the program.
execute_process(COMMAND ${NM} -u ${LIBRARY} OUTPUT_VARIABLE undefined COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "U (_Z(NK?|TI)?[0-9]+)?(GDAL|GetGDAL|OGR|OSR|CPL|CSL|VSI)[A-Za-z0-9_]*" names "${undefined}")
list(REMOVE_DUPLICATES names)
list(TRANSFORM names REPLACE "U (_ZTI.*)" "TYPEINFO(\\1)")
list(TRANSFORM names REPLACE "U (.*)" "FUNCTION(\\1)")
list(JOIN names "\n" names)
file(WRITE ${OUTPUT} "${names}\n")
