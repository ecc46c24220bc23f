/* Modules of the kernel; here there is none. */
#define MODULE_LICENSE(text) struct rtapi_license
#define EXPORT_SYMBOL(name) struct rtapi_export
int rtapi_app_main(void);
void rtapi_app_exit(void);
